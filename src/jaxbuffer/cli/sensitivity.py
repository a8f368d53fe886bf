"""`jaxbuffer sensitivity`: one run's gradients and elasticities, certified."""

from typing import Annotated

import typer

from .exits import fail
from .limits import keeps_limits, study_constraints
from .request import CommandLine, ScenarioNumber, given
from .scheduler import Scheduler


def sensitivity(
    request: CommandLine,
    wrt: Annotated[
        list[str] | None,
        typer.Option(metavar="FIELD", help="Differentiate by FIELD; repeatable; default: the buffer's."),
    ] = None,
    of: Annotated[
        list[str] | None,
        typer.Option(metavar="QUANTITY", help="Differentiate QUANTITY; repeatable; default: the first five below."),
    ] = None,
    certify: Annotated[
        str, typer.Option(metavar="HOW", help="quick (default), thorough (a difference a parameter) or none.")
    ] = "quick",
    scenario_number: ScenarioNumber = None,
    scheduler: Scheduler = None,
) -> int:
    """Differentiate one run: gradients and elasticities of peak forces, stroke, hinge angle and end time, or of any
    quantity below.

    They come with a certificate: estimated errors from a second tolerance and from differences of tight simulations,
    the active peak and its runner-up, and a verdict: trusted, check or refused. Of a capture that did not succeed,
    --of capture_share says by how much each parameter would have to change, to first order. --scheduler hands these
    simulations to a Dask cluster, which is worth it where one takes seconds.

    \b
    Files in DIR:
      sensitivity.json, sensitivity.csv  values, gradients, elasticities, units
      sensitivity.txt                    the tables

    \b
    Examples:
      jaxbuffer sensitivity study.toml --wrt buffer.k_A --wrt probe.tip_mass
      jaxbuffer sensitivity --of peak_force --of impact.1.peak_force --of capture_margin --certify thorough
    """
    study = request.one_scenario(scenario_number)
    limits = study_constraints(study)
    files = request.files("sensitivity.json", "sensitivity.csv", "sensitivity.txt")
    from ..errors import check_choice
    from ..fields import check_numbers
    from ..mechanisms.quantity import check_quantities
    from ..run.request import ONE_RUN
    from ..sensitivities.sensitivity import CERTIFICATES
    from ..sensitivities.sensitivity import sensitivity as compute
    from .progress import working

    check_choice("certify", certify, CERTIFICATES)
    options, mechanism = study.options, study.mechanism
    names = check_quantities(mechanism.quantities, of or mechanism.defaults.differentiated)
    one = ONE_RUN.format(mechanism.view.run_name)
    paths, _ = check_numbers(study.design, study.scenario, wrt or mechanism.defaults.parameters, one)
    result = working(
        "differentiating",
        lambda: compute(
            study.design,
            study.scenario,
            paths,
            options.duration,
            quantities=names,
            rtol=options.rtol,
            solver=options.stepper(),
            certify=certify,
            **given(client=scheduler),
        ),
    )
    if result.run.outcome.failed:
        return fail(result.run.outcome.reason)
    from ..output.results import sensitivity_files

    contents = sensitivity_files(result, request.made(study))
    files.save_and_show(lambda: contents, result, lambda: str(contents["sensitivity.json"]()))
    return keeps_limits(limits, result.run)
