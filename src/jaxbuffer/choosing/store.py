"""The runs of a choice on disk: blocks, from which it goes on after whatever ended it, to the same bits."""

import contextlib
import dataclasses
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from ..block_store import ArchiveStore, BlockError, Head, Identity
from ..errors import InputError
from ..files import remove_all_drafts, whole_folder

FOLDER, BEGUN = "choose.runs", "begun.npz"
Key = tuple[int, int]  # a combination's number and a load case's place
Row = tuple[int, int, np.ndarray]  # code, impacts, values


def round_folder(number: int | str) -> str:
    """Return the folder of a further round of a choice, which has more corners of tolerances; "*" for any."""
    return f"{FOLDER}-{number}"


class Columns(NamedTuple):
    """Numbers of several runs: ``code`` of each outcome, ``impacts``, and ``values`` of the quantities that were asked
    for, in their order and units."""

    code: Int[np.ndarray, " runs"]
    impacts: Int[np.ndarray, " runs"]
    values: Float[np.ndarray, "runs quantities"]


@dataclasses.dataclass(frozen=True)
class _Blocks(ArchiveStore):
    """The archives of one choice: an empty one that is begun with, and numbered ones of runs."""

    def _refusal(self, identity: Identity, parts: list[str]) -> str:
        return (
            f"{self.folder} holds another choice, differing in {', '.join(parts)}; repeat the study and the options of"
            " the first, or choose another --output; it is left as it is"
        )


class ChoiceStore:
    """The runs of one choice that are done, and those that wait to be written, in blocks.

    **Arguments:** ``path``: its folder; ``identity``: of the choice; ``resume``: whether to go on with what is there.

    **Raises:** `InputError` on resuming another choice's, or a damaged one.
    """

    def __init__(self, path: Path, identity: Identity, resume: bool) -> None:
        self._rows: dict[tuple[Key, float], Row] = {}
        self._waiting: list[dict[str, np.ndarray]] = []
        self._next = 0
        # A choice of roundings tunes first: one that was ended by then has no runs yet.
        if resume and path.exists():
            self._blocks = self._resumed(path, identity)
            return
        head = Head(identity, uuid.uuid4().hex)
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_folder(path) as draft:
            _Blocks(head, draft).write(BEGUN, {})
        self._blocks = _Blocks(head, path)

    def _resumed(self, path: Path, identity: Identity) -> _Blocks:
        try:
            blocks = _Blocks.of(path, BEGUN)
            blocks.read(BEGUN)
        except BlockError as error:
            raise InputError(f"{path / BEGUN} {error} and cannot be resumed; it is left as it is") from None
        blocks.check_identity(identity)
        remove_all_drafts(path)
        for file in sorted(path.glob("[0-9]*.npz")):
            # A damaged block counts too: it stays, and no new one takes its name.
            self._next = max(self._next, int(file.stem) + 1)
            with contextlib.suppress(BlockError):  # its runs are computed again
                block = blocks.read(file.name)
                keys, rtol = block["keys"].tolist(), float(block["rtol"])
                rows = zip(block["code"].tolist(), block["impacts"].tolist(), block["values"], strict=True)
                self._rows |= {((key[0], key[1]), rtol): row for key, row in zip(keys, rows, strict=True)}
        return blocks

    def row(self, key: Key, rtol: float) -> Row | None:
        """Return the numbers of a run that is done, at a tolerance of ``rtol`` [-]; None of any other."""
        return self._rows.get((key, rtol))

    def add(self, keys: Sequence[Key], rtol: float, columns: Columns) -> None:
        """Take runs that are done, which the next `save` writes."""
        self._waiting.append({"keys": np.array(keys, np.int64), "rtol": np.array(rtol), **columns._asdict()})

    def save(self) -> None:
        """Write the runs that wait."""
        while self._waiting:
            self._blocks.write(f"{self._next:06d}.npz", self._waiting[0])
            # After it is written: an error in between has it written again.
            del self._waiting[0]
            self._next += 1
