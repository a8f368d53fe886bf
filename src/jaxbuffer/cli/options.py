"""Options of several commands, and how a function's signature and docstring become a command.

Such a function has no body: what the command does is a function of the same name in `cli.commands`.
"""

import contextlib
import functools
import importlib
import inspect
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Annotated, Any

import typer

from ..files import cache_folder, user_path
from . import completion
from .overrides import Command, Plain

Figures = Annotated[
    str | None,
    typer.Option(
        "--format",
        metavar="FORMAT",
        help="Of figures: png (default), svg, both or none.",
        show_default=False,
        autocompletion=completion.one_of("png", "svg", "both", "none"),
    ),
]

Force = Annotated[bool, typer.Option("--force", help="Overwrite result files that exist.")]

SHARED = {
    "config": Annotated[
        Path | None,
        typer.Argument(
            metavar="CONFIG.toml",
            help="The study; default: Table 2.",
            autocompletion=completion.files_or_value,
        ),
    ],
    "solver": Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="automatic (default), implicit, explicit, or diffrax:METHOD, diffrax:Kvaerno5 say.",
            show_default=False,
            autocompletion=completion.one_of("automatic", "implicit", "explicit"),
        ),
    ],
    "rtol": Annotated[str | None, typer.Option(metavar="TOL", help="Relative error of a step; default 1e-6.")],
    "duration": Annotated[
        str | None, typer.Option(metavar="S", help="Simulated time until timeout [s]; default: the mechanism's.")
    ],
    "output": Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for result files; default: none.")],
    "force": Force,
    "figures": Figures,
    "as_json": Annotated[bool, typer.Option("--json", help="Print the record as JSON, and messages on stderr.")],
}

ScenarioNumber = Annotated[
    str | None, typer.Option(metavar="N", help="Which of the study's [[scenarios]], from 1; default: the first.")
]

Trust = Annotated[
    str,
    typer.Option(
        metavar="WHEN",
        help="Whether to run again at a tenth of the tolerance: on or off.",
        autocompletion=completion.one_of("on", "off"),
    ),
]

Levers = Annotated[
    str,
    typer.Option(
        metavar="WHEN",
        help="Whether to find what moves each limited quantity most, among all numbers: on or off (default).",
        autocompletion=completion.one_of("on", "off"),
    ),
]

Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="WHERE",
        help="Over Dask: local (threads), processes, or an address as tcp://HOST:8786; see docs/clusters.md.",
        show_default=False,
    ),
]

Resume = Annotated[bool, typer.Option("--resume", help="Go on with the run in DIR, however it ended.")]

# The settings of a search.
Iterations = Annotated[str | None, typer.Option(metavar="N", help="Steps of a search at most; default 40.")]
Starts = Annotated[str | None, typer.Option(metavar="N", help="Designs screened in a round; default 32.")]
Seed = Annotated[str | None, typer.Option(metavar="N", help="Of the starts' sample; default 0.")]


def verb(
    app: typer.Typer,
    function: Callable[..., None],
    summary: str,
    without: Collection[str] = (),
    kind: type[Command] = Command,
    module: str = "",
) -> None:
    """Make a function of options of its own a command of ``app`` that takes the shared options too.

    **Arguments:** ``summary``: its line in the list of commands; ``without``: names of shared options it has not;
    ``kind`` of command, which says what its help ends with; ``module`` of `cli.commands`, by default of the same name:
    its function takes a `CommandLine` and the command's own options.
    """
    name = function.__name__
    shared = {
        option: inspect.Parameter(
            option,
            inspect.Parameter.KEYWORD_ONLY,
            # None tells an option that was left out, which must not replace what the study says.
            default=False if option in ("force", "as_json") else None,
            annotation=annotation,
        )
        for option, annotation in SHARED.items()
        if option not in without
    }
    own = list(inspect.signature(function).parameters.values())
    context = inspect.Parameter("ctx", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context)

    def command(ctx: typer.Context, **options: Any) -> int:
        # Before the imports of JAX, which belong to the time that a result's record tells.
        begun, words = time.perf_counter(), ctx.find_root().obj or ()
        options = _as_meant(options)
        general = {option: options.pop(option) for option in shared}
        # The options are part of the key, because other ones may need other programs.
        with _programs_loading(" ".join([name, *sorted(it for it in general if general[it])])):
            request = _imported("request", "CommandLine")(ctx.obj, words, begun, **general)
            return _imported(module or name, name)(request, **options)

    # CONFIG.toml comes first; in the help a command's own options stand before the shared ones.
    first, *others = shared.values()
    # By name only, so that options may stand in any order in the signature.
    keywords = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]
    # typer reads a command's options off its signature and annotations.
    command.__signature__ = inspect.Signature([context, first, *keywords, *others])  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in [context, first, *keywords, *others]}
    command.__name__, command.__doc__ = name, function.__doc__
    app.command(cls=kind, short_help=summary)(command)


def plain(app: typer.Typer, function: Callable[..., None], summary: str, module: str) -> None:
    """Make a function of options a command of ``app`` without the shared options; what it does is in that ``module``
    of `cli.commands`."""

    @functools.wraps(function)
    def command(**options: Any) -> int:
        return _imported(module, function.__name__)(**_as_meant(options))

    app.command(cls=Plain, short_help=summary)(command)


def _as_meant(options: dict[str, Any]) -> dict[str, Any]:
    """Return options whose paths have the home folder for a leading "~", which a shell leaves in --output=~/results."""

    def meant(value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return [meant(entry) for entry in value]
        return user_path(value) if isinstance(value, Path) else value

    return {name: meant(value) for name, value in options.items()}


def _programs_loading(command: str) -> contextlib.AbstractContextManager[None]:
    """Set JAX up, and begin to load the programs that such a command needed last time."""
    from ..programs import ahead, process  # these import JAX

    process.configure(cache=cache_folder() or True)
    return ahead.loading(command)


def _imported(module: str, name: str) -> Callable[..., Any]:
    """Import a name of `cli.commands` only now: these modules import JAX, for which no help waits, nor a refusal."""
    return getattr(importlib.import_module(f".commands.{module}", __package__), name)
