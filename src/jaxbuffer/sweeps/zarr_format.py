"""Zarr's format 2, as far as sweeps use it: files of arrays, metadata beside them in JSON.

Only those who read a store as labelled arrays need the package `zarr`: the format is so plain that sweeps write it, and
resume, without it.
"""

import json
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..files import write_all
from ..labelled.arrays import Labelled

GROUP, ATTRIBUTES, ARRAY, ALL = ".zgroup", ".zattrs", ".zarray", ".zmetadata"
CODECS = {None, "zlib", "crc32", "zstd", "blosc"}  # ours and xarray's; others run code that a store brings: pickle


def array_metadata(shape: Sequence[int], chunks: Sequence[int], dtype: str, empty: Any) -> dict[str, Any]:
    """Return an array's metadata in Zarr's format 2."""
    return {
        "zarr_format": 2,
        "shape": list(shape),
        "chunks": list(chunks),
        "dtype": dtype,
        "compressor": {"id": "zlib", "level": 1},  # with a checksum: whoever reads a damaged file notices
        "filters": None,
        "fill_value": empty,
        "order": "C",
        "dimension_separator": "/",
    }


def write_coordinate(folder: Path, name: str, labelled: Labelled) -> dict[str, Any]:
    """Write a coordinate's values and return its metadata."""
    values, described = np.asarray(labelled.values), {"units": labelled.unit, "long_name": labelled.description}
    metadata = {key: text for key, text in described.items() if text}
    if values.dtype.kind == "b":  # as xarray stores truths
        values, metadata["dtype"] = values.astype("i1"), "bool"
    # One byte order on every machine, because it is a part of the type that the metadata name.
    values = values.astype(values.dtype.newbyteorder("<"))
    write({folder / name / "0": values})
    empty = "" if values.dtype.kind == "U" else 0
    return {
        f"{name}/{ARRAY}": array_metadata(values.shape, values.shape, values.dtype.str, empty),
        f"{name}/{ATTRIBUTES}": {"_ARRAY_DIMENSIONS": list(labelled.dims), **metadata},
    }


def write(files: Mapping[Path, np.ndarray]) -> None:
    """Write files of arrays, each whole or not at all, in this order, and none before there was room for all."""
    write_all({path: zlib.compress(values.tobytes(), 1) for path, values in files.items()})


def read(path: Path, dtype: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return a file's numbers. **Raises:** `OSError`, `ValueError` or `zlib.error` where it is missing or damaged."""
    return np.frombuffer(zlib.decompress(path.read_bytes()), dtype).reshape(shape)


def attributes(path: Path) -> dict[str, Any]:
    """Return a store's attributes, none where they are missing or damaged."""
    try:
        known = json.loads((path / ATTRIBUTES).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def check_codecs(path: Path) -> None:
    """Raise `InputError` for a store whose arrays hold more than numbers and words, before any of them is decoded."""
    try:
        listed = json.loads((path / ALL).read_text(encoding="utf-8"))["metadata"]
        arrays = [it for name, it in listed.items() if name.endswith(ARRAY)]
        # The list may leave out an array that lies in the store or describe it otherwise, and readers may go by either.
        arrays += [json.loads(file.read_text(encoding="utf-8")) for file in path.glob(f"*/{ARRAY}")]
        for it in arrays:
            codecs = {(codec or {}).get("id") for codec in (it["compressor"], *(it["filters"] or ()))}
            if not codecs <= CODECS or not isinstance(it["dtype"], str) or it["dtype"][1:2] not in "fiuU":
                raise InputError(f"{path} is no store of jaxbuffer: it has arrays of another kind; it is not read")
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path} is damaged or no store of jaxbuffer: {error}") from None
