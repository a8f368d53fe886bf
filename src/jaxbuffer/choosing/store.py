"""The runs of a choice on disk: sealed files, from which it goes on after whatever ended it, to the same bits."""

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from ..block_store import IDENTITY, Identity, described_identity, differing, identity_text
from ..errors import InputError
from ..files import remove_all_drafts, sealed, unsealed, whole_folder, write, write_all

FOLDER, HEAD = "choose.runs", "choose.json"
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


class ChoiceStore:
    """The store of one choice: numbered files of runs, each whole and with a checksum or not counted.

    **Arguments:** ``path``: its folder; ``identity``: of the choice; ``resume``: whether to go on with what is there.

    **Raises:** `InputError` on resuming another choice's, or a damaged one.
    """

    def __init__(self, path: Path, identity: Identity, resume: bool) -> None:
        self.path, self.identity = path, identity
        self._rows: dict[tuple[Key, float], Row] = {}
        self._waiting: list[tuple[list[Key], float, Columns]] = []
        self.damaged, self._next = 0, 0
        # A choice of roundings tunes first: one that was ended by then has no runs yet.
        if resume and path.exists():
            self._resume()
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            with whole_folder(path) as draft:
                write(draft / HEAD, json.dumps({IDENTITY: identity_text(identity)}))

    def _resume(self) -> None:
        head = self.path / HEAD
        try:
            before = described_identity(json.loads(head.read_text(encoding="utf-8")))
        except (OSError, ValueError):
            before = None
        if before is None:
            raise InputError(f"{head} is damaged and cannot be resumed; it is left as it is")
        if parts := differing(self.identity, before):
            raise InputError(
                f"{self.path} holds another choice, differing in {', '.join(parts)}; repeat the study and the options"
                " of the first, or choose another --output; it is left as it is"
            )
        remove_all_drafts(self.path)
        for file in sorted(self.path.glob("*.npz")):
            # A damaged file counts too: it stays, and no new one takes its name.
            self._next = max(self._next, int(file.stem) + 1)
            self._read(file)

    def _read(self, file: Path) -> None:
        """Read a file of runs; those of one that is damaged are computed again."""
        try:
            content = unsealed(file.read_bytes())
            if content is None:
                raise ValueError("it has no checksum")
            with np.load(io.BytesIO(content)) as arrays:
                keys, rtol = arrays["keys"].tolist(), float(arrays["rtol"])
                rows = zip(arrays["code"].tolist(), arrays["impacts"].tolist(), arrays["values"], strict=True)
                self._rows |= {((key[0], key[1]), rtol): row for key, row in zip(keys, rows, strict=True)}
        except (ValueError, KeyError, OSError, EOFError):
            self.damaged += 1

    def row(self, key: Key, rtol: float) -> Row | None:
        """Return the numbers of a run that is done, at a tolerance of ``rtol`` [-]; None of any other."""
        return self._rows.get((key, rtol))

    def add(self, keys: Sequence[Key], rtol: float, columns: Columns) -> None:
        """Take runs that are done, which the next `save` writes."""
        self._waiting.append((list(keys), rtol, columns))

    def save(self) -> None:
        """Write the runs that wait."""
        files: dict[Path, bytes] = {}
        for keys, rtol, columns in self._waiting:
            content = io.BytesIO()
            arrays: dict[str, Any] = columns._asdict()
            np.savez(content, keys=np.array(keys, np.int64), rtol=rtol, **arrays)
            files[self.path / f"{self._next:06d}.npz"] = sealed(content.getvalue())
            self._next += 1
        self._waiting.clear()
        write_all(files)
