"""What a process's numbers depend on besides its input: our source, the packages, the processor, XLA's settings."""

import functools
import hashlib
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

from .backend import one_kernel
from .identity import PACKAGES

HOST = ("processor", "backend", "XLA")  # what a machine has, rather than an installation


@functools.cache
def source() -> str:
    """A hash of this package's own source."""
    content, top = hashlib.sha256(), Path(__file__).parents[1]
    for file in sorted(top.rglob("*.py")):
        content.update(f"{file.relative_to(top)}\0".encode() + file.read_bytes())
    return content.hexdigest()[:16]


def processor() -> str:
    """What the machine's code may use."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.platform())


def kind() -> dict[str, str]:
    """All of it in short words, by name: two processes that agree in it compute the same bits."""
    import jax

    return {
        "jaxbuffer": source(),
        "Python": sys.version.split()[0],
        **{name: version(name) for name in PACKAGES},
        "processor": hashlib.sha256(processor().encode()).hexdigest()[:16],
        "backend": f"{jax.default_backend()} {jax.dtypes.canonicalize_dtype(float)}",
        "XLA": hashlib.sha256(f"{os.environ.get('XLA_FLAGS', '')} {one_kernel()}".encode()).hexdigest()[:16],
    }
