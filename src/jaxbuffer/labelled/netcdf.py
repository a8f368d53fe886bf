"""Datasets as netCDF-4 files, which xarray, MATLAB, Julia and ncdump read."""

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    import xarray as xr

SUFFIX = ".nc"
LARGE = 2**14  # bytes, from which on an array is compressed


def content(dataset: "xr.Dataset") -> bytes:
    """A dataset as a file's content, numbers to the last bit, large arrays compressed."""
    large = {
        name: {"zlib": True} for name, it in dataset.data_vars.items() if it.nbytes > LARGE and it.dtype.kind == "f"
    }
    return bytes(dataset.to_netcdf(engine="h5netcdf", encoding=large))


def read(file: Path) -> "xr.Dataset":
    """The dataset of a file, wholly in memory. **Raises:** `InputError` where it is none, or damaged."""
    import xarray as xr

    try:
        with file.open("rb") as stored:
            return xr.load_dataset(stored, engine="h5netcdf")
    except OSError as error:
        reason = error.strerror or "it is no netCDF-4 file"
    except Exception as error:  # HDF5 fails in many ways; all mean the same
        reason = str(error)
    raise InputError(f"{file} is damaged or no result of jaxbuffer: {reason}")
