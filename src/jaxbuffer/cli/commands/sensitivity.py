"""`jaxbuffer sensitivity`: one run's gradients and elasticities, certified."""

from ...cluster.extra import executor_at
from ...errors import check_choice
from ...fields import check_numbers
from ...mechanisms.quantity import check_differentiable
from ...output.run_files import sensitivity_files
from ...run.request import ONE_RUN
from ...sensitivities.sensitivity import CERTIFICATES
from ...sensitivities.sensitivity import sensitivity as compute
from ..exits import fail
from .progress import working
from .request import CommandLine
from .simulate import keeps_limits, study_constraints


def sensitivity(
    request: CommandLine,
    wrt: list[str] | None,
    of: list[str] | None,
    certify: str,
    scenario_number: str | None,
    scheduler: str | None,
) -> int:
    """Differentiate a run."""
    study = request.one_scenario(scenario_number)
    limits = study_constraints(study)
    files = request.files("sensitivity.json", "sensitivity.csv", "sensitivity.txt", "sensitivity.png")
    check_choice("certify", certify, CERTIFICATES)
    options, mechanism = study.options, study.mechanism
    names = check_differentiable(mechanism.quantities, of or mechanism.defaults_for(study.design).differentiated)
    one = ONE_RUN.format(mechanism.view.run_name)
    paths, _ = check_numbers(study.design, study.scenario, wrt or mechanism.parameters(study.design), one)
    with executor_at(scheduler) as (executor, _):
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
                executor=executor,
            ),
        )
    if result.run.outcome.failed:
        return fail(result.run.outcome.reason)
    contents = sensitivity_files(result, request.made(study))
    files.save_record(contents, result, "sensitivity.json")
    return keeps_limits(limits, result.run)
