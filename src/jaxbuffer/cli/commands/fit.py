"""`jaxbuffer fit`: a design's numbers from measured tests."""

from ...fitting.fit import fit as compute
from ...output.fit_files import fit_files
from ..exits import LIMITS_BROKEN, OK, fail
from .progress import fitting
from .request import CommandLine, say_cautions


def fit(request: CommandLine) -> int:
    """Fit the study's design to its tests, and save it."""
    study = request.study()
    recordings = study.fit.recordings(study.design, study.scenario, study.folder)
    parameters = dict(study.fit.parameters or {})
    say_cautions([(study.design, it.scenario) for it in recordings], set(parameters))
    files = request.files("design.toml", "fit.json", "fit.csv", "fit.png", "fit.txt")
    fitted = fitting(
        lambda report: compute(
            study.design,
            study.scenario,
            recordings,
            parameters,
            duration=study.options.duration,
            rtol=study.options.rtol,
            report=report,
        )
    )
    contents = fit_files(fitted, request.made(study), study.units)
    files.save_and_show(lambda: contents, fitted, lambda: str(contents["fit.json"]()))
    if not fitted.explained:
        reason = f"the fit does not explain the test: residuals of up to {fitted.largest_residual:.3g} deviations"
        return fail("; ".join([reason, *fitted.doubtful]), LIMITS_BROKEN)
    return OK if fitted.converged else fail("the fit has not converged")
