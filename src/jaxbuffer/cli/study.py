"""`jaxbuffer init`, `check`, `schema` and `fields`: a study to begin with, what one says, what studies are made of."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import InputError
from .exits import OK
from .streams import show

if TYPE_CHECKING:
    from ..mechanisms.mechanism import Mechanism


Kind = Annotated[str, typer.Option("--kind", metavar="NAME", help="The mechanism; 'jaxbuffer fields' lists them.")]
STUDY = Path("study.toml")


def init(
    file: Annotated[Path, typer.Argument(metavar="[FILE]", help=f"The study to write; default: {STUDY}.")] = Path(
        STUDY
    ),
    kind: Kind = "",
    force: Annotated[bool, typer.Option("--force", help="Overwrite FILE if it exists.")] = False,
) -> int:
    """Write an example study of a mechanism: every field with its unit, range, default and meaning.

    It loads as it is; take away the # before what you want to change. Without --kind it is of the capture mechanism.

    \b
    Example: jaxbuffer init --kind bar_drop drop.toml
    """
    from ..files import write
    from ..study.example import example_toml

    text = example_toml(_mechanism(kind))
    try:
        write(file, text, overwrite=force)
    except FileExistsError:
        raise InputError(f"{file} exists; --force overwrites, another FILE keeps it") from None
    show(f"wrote {file}; 'jaxbuffer check {file}' says what it holds")
    return OK


def check(file: Annotated[Path, typer.Argument(metavar="FILE", help="The study.")]) -> int:
    """Say whether a study can be used, what differs from the defaults, and what each command would do with it.

    What is wrong is one line, with the nearest name for one that is unknown, and exit code 2.

    \b
    Example: jaxbuffer check study.toml
    """
    from ..programs.process import cache_folder, configure

    configure(cache=cache_folder())
    from ..study.config import load
    from ..study.explained import explained

    try:
        show(explained(load(file), str(file)))
    except InputError as error:
        raise error if str(error).startswith(f"{file}") else InputError(f"{file}: {error}") from None
    return OK


def schema(kind: Kind = "") -> int:
    """Print the JSON Schema of a mechanism's studies, with which editors complete and check them (docs/studies.md).

    \b
    Example: jaxbuffer schema --kind bar_drop > jaxbuffer.schema.json
    """
    from ..output.formats import json_text
    from ..study.schema import study_schema

    show(json_text(study_schema(_mechanism(kind))).rstrip())
    return OK


def _mechanism(kind: str) -> "Mechanism":
    from ..mechanisms import mechanism_named
    from ..study.config import DEFAULT_KIND

    return mechanism_named(kind or DEFAULT_KIND)


def fields(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="A mechanism's name, as kind in CONFIG.toml.")] = "",
) -> int:
    """List a mechanism's fields with units, defaults and ranges, and the quantities of its runs; without KIND, the
    mechanisms there are.

    \b
    Example: jaxbuffer fields
    """
    from ..mechanisms import all_mechanisms, mechanism_named
    from ..mechanisms.described import described

    if kind:
        show(described(mechanism_named(kind)))
        return OK
    for known in all_mechanisms():
        show(f'kind = "{known.name}"  {known.view.title}')
    return OK
