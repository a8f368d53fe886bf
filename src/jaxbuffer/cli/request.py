"""What every command takes: a study, how to simulate, and where to write."""

import dataclasses
import inspect
import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError, check_choice
from .overrides import FIELDS, Command

if TYPE_CHECKING:
    from ..study.config import Config
    from .output import Output

SHARED = {
    "config": Annotated[Path | None, typer.Argument(metavar="CONFIG.toml", help="The study; default: Table 2.")],
    "solver": Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="automatic (default), implicit, explicit, or diffrax:METHOD, diffrax:Kvaerno5 say.",
            show_default=False,
        ),
    ],
    "rtol": Annotated[str | None, typer.Option(metavar="TOL", help="Relative error of a step; default 1e-6.")],
    "duration": Annotated[str | None, typer.Option(metavar="S", help="Simulated time until timeout [s]; default 8.")],
    "output": Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for result files; default: none.")],
    "force": Annotated[bool, typer.Option("--force", help="Overwrite result files that exist.")],
    "as_json": Annotated[bool, typer.Option("--json", help="Print the record as JSON, and messages on stderr.")],
}

ScenarioNumber = Annotated[
    str | None, typer.Option(metavar="N", help="Which of the study's [[scenarios]], from 1; default: the first.")
]

Trust = Annotated[
    str, typer.Option(metavar="WHEN", help="Whether to run again at a tenth of the tolerance: on or off.")
]


@dataclasses.dataclass(frozen=True)
class CommandLine:
    """One call of a command, options as typed. ``fields``: design and scenario fields by dotted path; ``words``: all
    that was typed after the program's name; ``begun``: when, of the clock `time.perf_counter` [s]."""

    fields: dict[str, str]
    config: Path | None = None
    solver: str | None = None
    rtol: str | None = None
    duration: str | None = None
    output: Path | None = None
    force: bool = False
    as_json: bool = False
    words: tuple[str, ...] = ()
    begun: float = dataclasses.field(default_factory=time.perf_counter)

    def study(self) -> "Config":
        """The study with everything the command line overrides; JAX is set up on the way."""
        from ..programs.process import cache_folder, check_ready, configure

        configure(cache=cache_folder())
        from ..study.config import apply_options, apply_overrides, load

        study = apply_overrides(load(self.config), self.fields)
        options = given(solver=self.solver, rtol=self.rtol, duration=self.duration)
        study = dataclasses.replace(study, options=apply_options(study.options, options))
        check_ready()  # before a folder is made
        return study

    def one_scenario(self, number: str | None) -> "Config":
        """The study with the scenario of that number among its [[scenarios]], counted from 1; without one, its first
        or that of [scenario], which a line on stderr says where there are several."""
        from ..study.config import chosen_scenario

        study, note = chosen_scenario(self.study(), number)
        if note:
            typer.echo(f"note: {note}", err=True)
        return study

    def made(self, study: "Config", resumed: bool = False) -> dict[str, Any]:
        """How the result came about that is known by now, for its record."""
        from ..output.provenance import made

        options, read = study.options, None
        if self.config is not None and self.config.is_file():
            read = self.config.read_text(encoding="utf-8", errors="replace")
        duration = options.duration if options.duration is not None else study.mechanism.defaults.duration
        settings = {"solver": options.solver, "rtol [-]": float(options.rtol), "duration [s]": float(duration)}
        about = made(self.words, read, settings, time.perf_counter() - self.begun, resumed)
        return {**about, "units": dict(study.units)}

    def files(self, *names: str, resumable: Sequence[str] = (), resume: bool = False) -> "Output":
        """Files to write later; everything that can go wrong with it is found now, before computing them.

        **Arguments:** ``resumable``: files of a run that ``resume`` goes on with; it may overwrite the others.
        """
        from .output import Output

        if resume and self.output is None:
            raise InputError("--resume needs --output DIR, the folder of the run to go on with")
        if self.output is not None and any(name.endswith(".png") for name in names):
            from ..output.style import require_matplotlib

            require_matplotlib()
        return Output(self.output, names, self.force, resumable, resume, self.as_json)


def verb(
    app: typer.Typer, summary: str, without: Collection[str] = (), epilog: str = FIELDS
) -> Callable[[Callable[..., int]], Any]:
    """Make a function of a `CommandLine` and options of its own a command of ``app``, with the shared options.

    **Arguments:** ``summary``: its line in the list of commands; ``without``: names of shared options it has not;
    ``epilog``: what its help ends with.
    """

    def register(function: Callable[..., int]) -> Callable[..., int]:
        shared = {
            name: inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=False if name in ("force", "as_json") else None,
                annotation=annotation,
            )
            for name, annotation in SHARED.items()
            if name not in without
        }
        own = list(inspect.signature(function).parameters.values())[1:]
        context = inspect.Parameter("ctx", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context)

        def command(ctx: typer.Context, **options: Any) -> int:
            typed = ctx.find_root().obj or ()
            request = CommandLine(ctx.obj, words=typed, **{name: options.pop(name) for name in shared})
            return function(request, **options)

        first, *others = shared.values()
        keywords = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]
        command.__signature__ = inspect.Signature([context, first, *keywords, *others])  # type: ignore[attr-defined]
        command.__annotations__ = {p.name: p.annotation for p in [context, first, *keywords, *others]}
        command.__name__, command.__doc__ = function.__name__, function.__doc__
        app.command(cls=Command, epilog=epilog, short_help=summary)(command)
        return function

    return register


def each_once(over: Sequence[str], typed: Callable[[str], tuple[str, Any]], instead: str) -> dict[str, Any]:
    """Return what several --over say, by field, each read by ``typed``. **Raises:** `InputError` for a field that is
    given twice, with what to do ``instead``."""
    asked = dict[str, Any]()
    for path, values in map(typed, over):
        if path in asked:
            raise InputError(f"--over {path} is given more than once; {instead}")
        asked[path] = values
    return asked


def given(**options: Any) -> dict[str, Any]:
    """Those options that were given."""
    return {name: value for name, value in options.items() if value is not None}


def asked_for(trust: str) -> bool:
    """Whether it is on."""
    check_choice("trust", trust, ("on", "off"))
    return trust == "on"
