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
from ...study.scaled import scaled_toml
from ...study.schema import study_schema
from ..exits import OK
from ..streams import show


def init(
    file: Path | None,
    kind: str,
    own: str,
    active_mass: str,
    passive_mass: str,
    speeds: str,
    miss: str,
    attitude: str,
    force: bool,
) -> int:
    """Write a study, or with ``own`` a mechanism of that name, to begin with."""
    slowest, _, fastest = speeds.partition(":")
    typed = {"active_mass": active_mass, "passive_mass": passive_mass, "slowest": slowest}
    typed |= {"fastest": fastest or slowest, "miss": miss, "attitude": attitude}
    given = {name: number_or_text(text) for name, text in typed.items() if text}
    if own and (kind or given):
        raise InputError(
            "--own writes a mechanism of your own, the rest a study of one that there is: give one of them"
        )
    target = file or Path(f"{own}.py" if own else "study.toml")
    if own:
        text = own_mechanism(own)
    else:
        text = scaled_toml(_mechanism(kind), given) if given else example_toml(_mechanism(kind))
    try:
        write(target, text, overwrite=force)
    except FileExistsError:
        raise InputError(f"{target} exists; --force overwrites, another FILE keeps it") from None
    next_step = f"'python {target}' runs it" if own else f"'jaxbuffer check {target}' says what it holds"
    show(f"wrote {target}; {next_step}")
    return OK


def number_or_text(typed: str) -> float | str:
    """Return a number without a unit as such: it is in its field's unit."""
    try:
        return float(typed)
    except ValueError:
        return typed


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
