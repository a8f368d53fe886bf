"""Fields that take the mesh of a planar shape: a file, or a mesh of scikit-fem.

Their value is the mesh as text, scikit-fem's JSON, so that a design is complete in itself wherever it is kept, and a
program is made for the mesh rather than for the name of a file.
"""

import contextlib
import functools
import json
import os
from typing import Any

import equinox as eqx

from ..errors import InputError, shown, suggest
from ..files import user_path

SHAPES = {3: "MeshTri", 4: "MeshQuad"}  # by corners of a cell


def mesh(*boundaries: str, doc: str = "") -> Any:
    """Declare a static field that takes a mesh with these named ``boundaries``; ``doc`` as of `number`."""

    def check(path: str, value: Any) -> None:
        if value is None:
            return
        if not (isinstance(value, str) and value.startswith("{")):
            _read(path, value)
        try:
            known = mesh_of(value).boundaries or {}
        except (ValueError, KeyError, IndexError, TypeError) as error:
            raise InputError(f"{path} is no mesh as scikit-fem writes it: {error}") from None
        for name in boundaries:
            if name not in known or not len(known[name]):
                raise InputError(
                    f"{path}: the mesh has no boundary {name}{suggest(name, known) if known else ''}; name a physical"
                    " line so in gmsh, or use with_boundaries of scikit-fem"
                )

    metadata = {"mesh": boundaries, "check": check, "doc": doc}
    return eqx.field(default=None, static=True, converter=_as_text, metadata=metadata)


@functools.lru_cache(maxsize=64)
def mesh_of(text: str) -> Any:
    """Return the scikit-fem mesh of a field's value."""
    import skfem  # takes long to import

    data = json.loads(text)
    return getattr(skfem, SHAPES[len(data["t"][0])]).from_dict(data)


def _as_text(value: Any) -> Any:
    """Return a mesh or a mesh file as text; any other value as it is, for the check that names its field."""
    if value is None or (isinstance(value, str) and value.startswith("{")):
        return value
    with contextlib.suppress(InputError):
        return _read("", value)
    return value


def _read(path: str, value: Any) -> str:
    """Return the text of a mesh or a file. **Raises:** `InputError`, with ``path`` the field's name."""
    import skfem  # takes long to import
    from skfem.io.json import from_file

    if isinstance(value, str | os.PathLike):
        file = user_path(value)
        if not file.is_file():
            raise InputError(f"{path} = {shown(str(value))}: no such file")
        try:
            value = from_file(file) if file.suffix == ".json" else skfem.Mesh.load(str(file))
        except ImportError as missing:
            raise InputError(f"{path} = {shown(str(file))}: this file needs meshio: pip install meshio") from missing
        except Exception as error:  # of any reader, on any damage
            raise InputError(f"{path} = {shown(str(file))} cannot be read as a mesh: {error}") from error
    if not isinstance(value, skfem.MeshTri1 | skfem.MeshQuad1) or isinstance(value, skfem.MeshTri2 | skfem.MeshQuad2):
        raise InputError(
            f"{path} = {shown(value)} is no planar mesh; give a file of straight triangles or quadrilaterals, or a"
            " MeshTri or MeshQuad of scikit-fem"
        )
    return json.dumps(value.to_dict() | {"subdomains": None})
