"""Datasets as netCDF-4 files, which xarray, MATLAB, Julia and ncdump read.

A checksum of the file stands behind its end, where HDF5 does not look: HDF5 itself notices few flipped bits.
"""

import io
from pathlib import Path

from .._types import Dataset
from ..errors import InputError
from ..files import sealed, unsealed

SUFFIX = ".nc"
LARGE = 2**14  # bytes, from which on an array is compressed


def content(dataset: Dataset) -> bytes:
    """Return a dataset as a file's content, numbers to the last bit, large arrays compressed."""
    large = {
        name: {"zlib": True} for name, it in dataset.data_vars.items() if it.nbytes > LARGE and it.dtype.kind == "f"
    }
    return sealed(bytes(dataset.to_netcdf(engine="h5netcdf", encoding=large)))


def read(file: Path) -> Dataset:
    """Return the dataset of a file, wholly in memory. **Raises:** `InputError` where it is none, or damaged.

    A file without a checksum is of another program, and read as it is.
    """
    import xarray as xr

    try:
        stored = file.read_bytes()
        written = unsealed(stored)
        return xr.load_dataset(io.BytesIO(stored if written is None else written), engine="h5netcdf")
    except OSError as error:
        reason = error.strerror or str(error).partition("\n")[0]
    except Exception as error:  # HDF5 fails in many ways; all mean the same
        reason = str(error)
    raise InputError(f"{file} is damaged or no result of jaxbuffer: {reason}")
