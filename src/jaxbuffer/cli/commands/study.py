"""`jaxbuffer init`, `check`, `schema` and `fields`: a study to begin with, what one says, what studies are made of."""

from pathlib import Path

from ...errors import InputError
from ...files import cache_folder, write
from ...mechanisms import all_mechanisms, mechanism_named
from ...mechanisms.described import described
from ...mechanisms.mechanism import Mechanism
from ...output.formats import json_text
from ...programs import process
from ...study.config import DEFAULT_KIND
from ...study.example import example_toml, own_mechanism
from ...study.explained import explained
from ...study.load import load
from ...study.schema import study_schema
from ..exits import OK
from ..streams import show


def init(file: Path | None, kind: str, own: str, force: bool) -> int:
    """Write a study, or with ``own`` a mechanism of that name, to begin with."""
    if own and kind:
        raise InputError("--own writes a mechanism of your own, --kind a study of one that there is: give one of them")
    target = file or Path(f"{own}.py" if own else "study.toml")
    text = own_mechanism(own) if own else example_toml(_mechanism(kind))
    try:
        write(target, text, overwrite=force)
    except FileExistsError:
        raise InputError(f"{target} exists; --force overwrites, another FILE keeps it") from None
    next_step = f"'python {target}' runs it" if own else f"'jaxbuffer check {target}' says what it holds"
    show(f"wrote {target}; {next_step}")
    return OK


def check(file: Path) -> int:
    """Print what a study says."""
    process.configure(cache=cache_folder() or True)
    try:
        show(explained(load(file), str(file)))
    except InputError as error:
        # What is wrong with the file itself names it already.
        raise error if str(error).startswith(f"{file}") else InputError(f"{file}: {error}") from None
    return OK


def schema(kind: str) -> int:
    """Print the JSON Schema of studies."""
    show(json_text(study_schema(_mechanism(kind))).rstrip())
    return OK


def fields(kind: str) -> int:
    """List fields and quantities, or the mechanisms."""
    if kind:
        show(described(mechanism_named(kind)))
        return OK
    for known in all_mechanisms():
        show(f'kind = "{known.name}"  {known.view.title}')
    return OK


def _mechanism(kind: str) -> Mechanism:
    return mechanism_named(kind or DEFAULT_KIND)
