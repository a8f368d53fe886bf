"""A sweep on disk: a store of blocks in Zarr's format, an array a quantity, cut into files as the sweep into blocks."""

import dataclasses
import json
import time
import uuid
import warnings
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._types import Dataset
from ..block_store import TOKEN, Arrays, BlockError, BlockStore, Head, Identity, MissingBlock
from ..cluster.extra import require
from ..errors import InputError
from ..files import Lock, naming, remove_all_drafts, whole_folder, write_all
from ..hybrid import name_of
from ..labelled.record import amount
from ..mechanisms.dataset import attributes
from ..mechanisms.mechanism import Mechanism
from ..run.trust import VERDICTS
from ..version import version
from . import zarr_format
from .columns import EMPTY, column_types
from .cut import Cut
from .spec import CODE, SweepSpec

STORE, FORMER = "sweep.zarr", "sweep.chunks"  # the second one was written by versions before this store
RESULT = ("sweep.json", "sweep.csv", "sweep.txt", "sweep.nc")  # files of a finished sweep
CHECKSUM = "checksum"
BLOCK, KIND = "block", "made_on"  # attributes, in JSON
PERIOD = 1.0  # s between the moments at which a sweep in this process stores what it has finished


@dataclasses.dataclass(frozen=True)
class SweepStore(BlockStore[int]):
    """The store of one sweep: a block has a number, a file for each of its columns, and one for its checksum.

    ``types``: the type of each column by name; ``cut``: into blocks.
    """

    path: Path
    types: Mapping[str, str]
    cut: Cut

    def write_columns(self, block: int, columns: Sequence[np.ndarray]) -> None:
        """Store a block's columns, (runs,) each.

        **Raises:** `InputError` where another store has taken the place of this one.
        """
        if zarr_format.attributes(self.path).get(TOKEN) != self.head.token:
            raise InputError(f"{self.path} has become another sweep's meanwhile; nothing was written to it")
        typed = zip(self.types.items(), columns, strict=True)
        self.write(block, {name: np.ravel(values).astype(kind) for (name, kind), values in typed})

    def file(self, name: str, block: int) -> Path:
        """Return a column's file of a block, or that of its checksum."""
        if name == CHECKSUM:
            return self.path / name / str(block)
        return self.path.joinpath(name, *map(str, self.cut.corner(block)))

    def _write_files(self, block: int, arrays: Arrays, checksum: int) -> None:
        shape = self.cut.shape(block)
        inside = tuple(slice(length) for length in shape)  # blocks at an edge are smaller than their files
        files = {}
        for name, values in arrays.items():
            kind = self.types[name]
            files[self.file(name, block)] = full = np.full(self.cut.block, EMPTY[kind], kind)
            full[inside] = values.reshape(shape)
        files[self.file(CHECKSUM, block)] = np.array([checksum], "<u8")
        # All files of a block are written together, so that an error names the store and not one of its columns.
        with naming(self.path):
            zarr_format.write(files)

    def _read_files(self, block: int) -> tuple[dict[str, np.ndarray], int]:
        inside = tuple(slice(length) for length in self.cut.shape(block))
        try:
            (checksum,) = zarr_format.read(self.file(CHECKSUM, block), "<u8", (1,))
        except FileNotFoundError:
            raise MissingBlock from None
        columns = {
            name: zarr_format.read(self.file(name, block), kind, self.cut.block)[inside].ravel()
            for name, kind in self.types.items()
        }
        return columns, int(checksum)

    def _refusal(self, identity: Identity, parts: list[str]) -> str:
        remedy = "repeat the study, the options and the same --over of the first, or choose another --output"
        return f"{self.path} holds another sweep, differing in {in_words(parts)}; {remedy}; it is left as it is"


def fill(store: SweepStore, columns: Mapping[str, np.ndarray]) -> None:
    """Fill columns (n,) with what is stored. A warning says how many blocks are damaged."""
    damaged, cut = 0, store.cut
    for block in range(len(cut)):
        try:
            stored = store.read(block)
        except MissingBlock:
            continue
        except BlockError:
            damaged += 1
            continue
        for name, values in stored.items():
            columns[name].reshape(cut.sizes)[cut.region(block)] = values.reshape(cut.shape(block))
    if damaged:
        blocks = "1 block is" if damaged == 1 else f"{damaged} blocks are"
        done = f"{int(np.sum(columns['code'] >= 0))} of {columns['code'].size} runs"
        warnings.warn(f"{store.path}: {blocks} damaged; going on with {done}", stacklevel=2)


class Saver:
    """The runs of a sweep in this process, stored about once a second until `close`.

    A block that has some of its runs only is stored with the others as not computed, and written again later.

    **Arguments:** ``columns``: an array (n,) a quantity, and ``finished`` (n,): which runs are in them. Both are read
    again at each `save`. Those that are finished now are in the store. ``lock``: of the folder.
    """

    def __init__(self, store: SweepStore, columns: Mapping[str, np.ndarray], finished: np.ndarray, lock: Lock) -> None:
        self.store, self.finished, self.lock = store, finished, lock
        self.columns, self.stored = [columns[name] for name in store.types], finished.copy()
        self.due = time.monotonic() + PERIOD

    def save(self, now: bool = False) -> None:
        """Store the blocks in which runs were finished since the last time, if that is long enough ago or ``now``."""
        if not now and time.monotonic() < self.due:
            return
        # The runs are marked as stored after they are written: an error in between has them written again.
        new = np.flatnonzero(self.finished & ~self.stored)
        for number in self.store.cut.numbers(new).tolist():
            self.store.write_columns(number, self._block(number))
        self.stored[new] = True
        self.due = time.monotonic() + PERIOD

    def close(self) -> None:
        """Store the rest and leave the folder to others."""
        try:
            self.save(now=True)
        finally:
            self.lock.release()

    def _block(self, number: int) -> list[np.ndarray]:
        """Return a block's columns, in which the runs that are not finished are blank.

        An interrupt may have come between two columns of a call.
        """
        region, sizes = self.store.cut.region(number), self.store.cut.sizes
        finished = self.finished.reshape(sizes)[region].ravel()
        parts = (column.reshape(sizes)[region].ravel() for column in self.columns)
        blanks = (EMPTY[kind] for kind in self.store.types.values())
        return [np.where(finished, part, blank) for part, blank in zip(parts, blanks, strict=True)]


def begun(path: Path, spec: SweepSpec, size: int, made_on: Mapping[str, str]) -> SweepStore:
    """Put a store there without any block, in place of what was there; it is whole or not there.

    ``size``: runs of a block at most; ``made_on``: the kind of process that computes what it will hold.
    """
    head, types, cut = Head(spec.identity, uuid.uuid4().hex), column_types(spec.mechanism), spec.cut(size)
    with whole_folder(path) as draft:
        metadata = _arrays(draft, spec, cut, types)
        metadata[zarr_format.GROUP] = {"zarr_format": 2}
        metadata[zarr_format.ATTRIBUTES] = {
            **attributes(spec.mechanism, *spec.first()[:2]),
            "settings": json.dumps(_settings(spec), sort_keys=True),
            BLOCK: json.dumps(cut.block),
            KIND: json.dumps(dict(made_on), sort_keys=True),
            **head.described(),
        }
        # Readers find all arrays in this one file, and need not look for each.
        metadata[zarr_format.ALL] = {"zarr_consolidated_format": 1, "metadata": dict(metadata)}
        write_all({draft / name: json.dumps(it).encode() for name, it in metadata.items()})
    return SweepStore(head, path, types, cut)


def _arrays(folder: Path, spec: SweepSpec, cut: Cut, types: Mapping[str, str]) -> dict[str, Any]:
    """Write a store's coordinates into a folder; return the metadata of all its arrays, by file."""
    metadata: dict[str, Any] = {}
    for name, it in spec.coordinates().items():
        metadata |= zarr_format.write_coordinate(folder, name, it)
    for name, kind in types.items():
        empty = -1 if kind == "<i8" else "NaN"
        described = {"_ARRAY_DIMENSIONS": list(spec.dims), **_description(spec.mechanism, name)}
        metadata[f"{name}/{zarr_format.ARRAY}"] = zarr_format.array_metadata(cut.sizes, cut.block, kind, empty)
        metadata[f"{name}/{zarr_format.ATTRIBUTES}"] = described
    described = {"_ARRAY_DIMENSIONS": ["block_number"], "long_name": "of each block of runs, once it is whole"}
    metadata[f"{CHECKSUM}/{zarr_format.ARRAY}"] = zarr_format.array_metadata((len(cut),), (1,), "<u8", 0)
    metadata[f"{CHECKSUM}/{zarr_format.ATTRIBUTES}"] = described
    return metadata


def _settings(spec: SweepSpec) -> dict[str, Any]:
    settings, (*_, duration) = spec.settings, spec.first()
    return {
        "rtol": amount(settings.rtol, "-"),
        "stabilisation": amount(settings.stabilisation, "1/s"),
        "duration": amount(duration, "s"),
        "solver": name_of(settings.solver),
        "trust": settings.trust,
    }


def resumed(path: Path, spec: SweepSpec) -> tuple[SweepStore, dict[str, str]]:
    """Return a store that is there, in the blocks that it was begun with, and the kind of process that made it.

    **Raises:** `InputError` where there is none, it is damaged, or another sweep's.
    """
    check_resumable(path)
    zarr_format.check_codecs(path)
    known = zarr_format.attributes(path)
    try:
        head = Head.of(known)
        block, made_on = (json.loads(known[name]) for name in (BLOCK, KIND))
        cut, made_on = Cut(spec.shape, tuple(map(int, block))), dict(made_on)
    except (BlockError, KeyError, ValueError, TypeError):
        raise InputError(f"{path} is damaged and cannot be resumed; it is left as it is") from None
    store = SweepStore(head, path, column_types(spec.mechanism), cut)
    store.check_identity(spec.identity)
    remove_all_drafts(path)  # what killed processes left half written
    return store, made_on


def in_words(parts: Sequence[str]) -> str:
    """Return in which parts the identities of two sweeps differ, as a sentence lists them."""
    words = {CODE: "the code of your own that its runs use"}
    *others, last = [words.get(name, name) for name in parts]
    return f"{', '.join(others)} and {last}" if others else last


def check_vacant(folder: Path, names: Iterable[str], force: bool) -> None:
    """Raise `InputError` for what is in a folder under some ``names``, unless ``force`` replaces it."""
    taken = [folder / name for name in names if (folder / name).exists()]
    if taken and not force:
        more = f" and {len(taken) - 1} more" if taken[1:] else ""
        exist, them = ("exist", "them") if more else ("exists", "it")
        raise InputError(
            f"{taken[0]}{more} {exist}; force=True replaces {them}, resume=True goes on with a sweep that was"
            f" interrupted, another folder keeps {them}"
        )


def check_resumable(path: Path) -> None:
    """Raise `InputError` where there is no store, saying which version wrote what is there in its place."""
    if path.exists():
        return
    former = path.with_name(FORMER)
    if not former.exists():
        missing = f"{STORE} is missing; leave out --resume to begin one"
        raise InputError(f"{path.parent}: there is no sweep to resume; {missing}")
    try:
        with former.open("rb") as file:
            writer = f"jaxbuffer {json.loads(file.readline(65536).partition(b' ')[2])['version']}"
    except (OSError, ValueError, KeyError, TypeError):
        writer = "an earlier jaxbuffer"
    raise InputError(f"{former} is a sweep of {writer}, which {version()} cannot resume; it is left as it is")


def is_unfinished(path: Path) -> bool:
    """Return whether a store lacks runs, of which a block may have some only."""
    try:
        count = json.loads((path / CHECKSUM / zarr_format.ARRAY).read_text(encoding="utf-8"))["shape"][0]
        # Metadata and drafts lie beside the checksums, of which alone the names are numbers.
        if sum(file.name.isdigit() for file in (path / CHECKSUM).iterdir()) < count:
            return True
        described = json.loads((path / "code" / zarr_format.ARRAY).read_text(encoding="utf-8"))
        cut = Cut(tuple(described["shape"]), tuple(described["chunks"]))
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        return False
    # Outcomes alone tell, which are read without identity and token.
    store = SweepStore(Head({}, ""), path, {"code": "<i8"}, cut)
    for number in range(len(cut)):
        inside = tuple(slice(length) for length in cut.shape(number))
        try:
            codes = zarr_format.read(store.file("code", number), "<i8", cut.block)
        except (OSError, ValueError, zlib.error):
            return True
        if np.any(codes[inside] < 0):
            return True
    return False


def opened(path: Path) -> Dataset:
    """Return a store as labelled arrays, which are read when they are used.

    **Raises:** `InputError` where it is damaged.
    """
    require()
    zarr_format.check_codecs(path)
    import xarray as xr  # takes a third of a second, which a sweep that is not read is spared

    try:
        # With masks xarray would take -1, the fill value of whole numbers, for missing and turn them all into floats.
        return xr.open_zarr(path, mask_and_scale=False).drop_vars(CHECKSUM)
    except Exception as error:  # no store at all, or metadata cut short: all mean the same
        raise InputError(f"{path} is damaged or no store of jaxbuffer: {error}") from None


def _description(mechanism: Mechanism, name: str) -> dict[str, Any]:
    """Return a column's attributes: its unit and meaning, or the meaning of each number as netCDF's conventions say."""
    if name == "code":
        codes = {it.name: int(it) for it in mechanism.outcomes}
        return {"long_name": "how the run ended, -1 where not computed", **_flags(codes)}
    if name == "trust":
        verdicts = {name: index for index, name in enumerate(VERDICTS)}
        return {"long_name": "how far the numbers can be trusted, -1 for no verdict", **_flags(verdicts)}
    quantity = mechanism.quantities.get(name)
    return {} if quantity is None else {"units": quantity.unit, "long_name": quantity.description}


def _flags(meanings: Mapping[str, int]) -> dict[str, Any]:
    return {"flag_values": list(meanings.values()), "flag_meanings": " ".join(meanings)}
