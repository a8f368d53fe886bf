"""A sweep as one Zarr store: an array a quantity, cut into files as the sweep is into blocks.

Each file is put in place whole. The block's checksum, of all its numbers, comes last: a block whose checksum is missing
or another one is not done, whatever ended its writer or damaged its files.
"""

import dataclasses
import functools
import hashlib
import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from ..errors import InputError
from ..files import naming
from ..labelled.arrays import Labelled, dataset
from ..mechanisms.mechanism import Mechanism
from ..run.trust import VERDICTS
from .columns import column_names, whole_numbers
from .cut import Block, Cut

if TYPE_CHECKING:
    import xarray as xr
    import zarr

DRAFT = ".sweep.zarr.draft"
CHECKSUM = "checksum"
IDENTITY, BLOCK, KIND, TOKEN = "identity", "block", "made_on", "token"  # attributes, the last one a word, else JSON
ATTRIBUTES, ARRAY, ALL = ".zattrs", ".zarray", ".zmetadata"  # in Zarr's format 2
CODECS = {None, "crc32", "zstd", "blosc"}  # ours and xarray's; others run code that a store brings: pickle


@dataclasses.dataclass(frozen=True)
class Store:
    """The store of one sweep, as the process that writes it sees it. ``token``: its own, made up with it."""

    path: Path
    token: str
    columns: tuple[str, ...]

    @functools.cached_property
    def arrays(self) -> "list[zarr.Array]":
        """An array a column, and that of the checksums."""
        group = group_of(self.path, "r+")
        return [group[name] for name in (*self.columns, CHECKSUM)]  # type: ignore[misc]

    def check(self) -> None:
        """Raise `InputError` where another store has taken its place, so that nothing is written there."""
        if _attributes(self.path).get(TOKEN) != self.token:
            raise InputError(f"{self.path} has become another sweep's meanwhile; nothing was written to it")

    def write(self, block: Block, found: Sequence[np.ndarray]) -> None:
        """Store a block's columns."""
        self.check()
        *arrays, checksums = self.arrays
        with naming(self.path):
            for array, values in zip(arrays, found, strict=True):
                array[block.region] = values.reshape(block.shape)
            checksums[block.number] = self._checksum(block, found)

    def read(self, block: Block) -> list[np.ndarray] | None:
        """A block's columns, (runs,) each; None where it is not there, or not whole."""
        *arrays, checksums = self.arrays
        try:
            expected = int(np.asarray(checksums[block.number]))
            if not expected:
                return None
            found = [np.asarray(array[block.region]).ravel() for array in arrays]
        except Exception:  # cut off, garbled: codecs and file systems fail in many ways, and all mean the same
            return None
        return found if self._checksum(block, found) == expected else None

    def _checksum(self, block: Block, found: Sequence[np.ndarray]) -> int:
        content = hashlib.blake2b(f"{self.token} {block.number}".encode(), digest_size=8)
        for values in found:
            content.update(np.ascontiguousarray(values).astype(values.dtype.newbyteorder("<")).tobytes())
        return int.from_bytes(content.digest(), "little") or 1


def create(
    path: Path,
    mechanism: Mechanism,
    cut: Cut,
    dims: tuple[str, ...],
    coordinates: Mapping[str, Labelled],
    about: Mapping[str, Any],
) -> None:
    """Put a store there without any block, in place of what was there; it is whole or not there."""
    import zarr

    draft = path.with_name(DRAFT)
    _removed(draft)
    with naming(path):
        dataset({}, coordinates, about).to_zarr(draft, zarr_format=2, consolidated=False)
        group = zarr.open_group(draft, mode="r+", zarr_format=2)
        codes = {it.name: int(it) for it in mechanism.outcomes}
        verdicts = {name: index for index, name in enumerate(VERDICTS)}
        whole = whole_numbers(mechanism)
        for name in column_names(mechanism):
            quantity = mechanism.quantities.get(name)
            told: dict[str, Any] = (
                {} if quantity is None else {"units": quantity.unit, "long_name": quantity.description}
            )
            if name == "code":
                told = {"long_name": "how the run ended, -1 where not computed", **_flags(codes)}
            if name == "trust":
                told = {"long_name": "how far the numbers can be trusted, -1 for no verdict", **_flags(verdicts)}
            _array(group, name, cut.sizes, cut.block, dims, -1 if name in whole else np.nan, told)
        told = {"long_name": "of each block of runs, once it is whole"}
        _array(group, CHECKSUM, (len(cut),), (1,), ("block_number",), np.uint64(0), told)
        zarr.consolidate_metadata(group.store)
        _removed(path)
        draft.rename(path)


def group_of(path: Path, mode: Literal["r", "r+"] = "r") -> "zarr.Group":
    """The arrays of a store. **Raises:** `InputError` where it is none of ours."""
    check_codecs(path)
    import zarr

    return zarr.open_group(path, mode=mode, zarr_format=2)


def check_codecs(path: Path) -> None:
    """Raise `InputError` for a store whose arrays hold more than numbers and words, before any of them is decoded."""
    try:
        listed = json.loads((path / ALL).read_text(encoding="utf-8"))["metadata"]
        found = [it for name, it in listed.items() if name.endswith(ARRAY)]
        found += [json.loads(file.read_text(encoding="utf-8")) for file in path.glob(f"*/{ARRAY}")]
        for it in found:
            codecs = {(codec or {}).get("id") for codec in (it["compressor"], *(it["filters"] or ()))}
            if not codecs <= CODECS or not isinstance(it["dtype"], str) or it["dtype"][1:2] not in "fiuU":
                raise InputError(f"{path} is no store of jaxbuffer: it has arrays of another kind; it is not read")
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path} is damaged or no store of jaxbuffer: {error}") from None


def remove_drafts(path: Path) -> None:
    """Remove what killed workers left half written."""
    for draft in path.rglob("*.partial"):
        draft.unlink(missing_ok=True)


def opened(path: Path) -> "xr.Dataset":
    """A store as labelled arrays, which are read when they are used. **Raises:** `InputError` where it is damaged."""
    from ..cluster.connect import require

    require()
    check_codecs(path)
    import xarray as xr

    try:
        return xr.open_zarr(path, mask_and_scale=False).drop_vars(CHECKSUM)
    except Exception as error:  # no store at all, or metadata cut short: all mean the same
        raise InputError(f"{path} is damaged or no store of jaxbuffer: {error}") from None


class Known(NamedTuple):
    """What a store says of itself: its sweep's ``identity``, the shape of a ``block``, the ``kind`` of process that it
    was made by, and its ``token``."""

    identity: dict[str, str]
    block: tuple[int, ...]
    kind: dict[str, str]
    token: str


def known(path: Path) -> Known:
    """Of a store that is there. **Raises:** `InputError` where it can't be told."""
    check_codecs(path)
    found = _attributes(path)
    try:
        identity, block, kind = (json.loads(found[name]) for name in (IDENTITY, BLOCK, KIND))
        return Known(dict(identity), tuple(map(int, block)), dict(kind), str(found[TOKEN]))
    except (KeyError, ValueError, TypeError):
        raise InputError(f"{path} is damaged and cannot be resumed; it is left as it is") from None


def _flags(meanings: Mapping[str, int]) -> dict[str, Any]:
    """What whole numbers mean, as netCDF's conventions say it."""
    return {"flag_values": list(meanings.values()), "flag_meanings": " ".join(meanings)}


def _array(
    group: "zarr.Group",
    name: str,
    shape: tuple[int, ...],
    chunks: tuple[int, ...],
    dims: tuple[str, ...],
    empty: Any,
    attributes: Mapping[str, Any],
) -> None:
    import numcodecs

    group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype=np.asarray(empty).dtype,
        fill_value=empty,
        filters=[numcodecs.CRC32()],  # whoever reads a damaged file is told
        compressors=numcodecs.Zstd(1),
        chunk_key_encoding={"name": "v2", "separator": "/"},
        attributes={"_ARRAY_DIMENSIONS": list(dims), **attributes},
    )


def _attributes(path: Path) -> dict[str, Any]:
    try:
        found = json.loads((path / ATTRIBUTES).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _removed(path: Path) -> None:
    """Remove a store as a whole: what is left of it after an interrupt has another name."""
    if path.name != DRAFT and path.exists():
        gone = path.with_name(f"{DRAFT}.old")
        _removed_now(gone)
        path.rename(gone)
        path = gone
    _removed_now(path)


def _removed_now(path: Path) -> None:
    if path.exists():
        shutil.rmtree(path)
