"""Compiled programs as bytes, and made ready to run again."""

import contextlib
import io
import uuid
import zlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.experimental import serialize_executable
from jax.extend.mlir import passmanager
from jax.stages import Compiled, Lowered

KEEPS = "jax_persistent_cache_min_compile_time_secs"  # JAX's own cache keeps what took longer to compile [s]
NEVER = 1e9


class MachineCode(NamedTuple):
    """A compiled function of arrays: the ``content`` as JAX pickles it, compressed; how many arrays are its ``inputs``
    and ``outputs``; whether it calls ``lapack``."""

    content: bytes
    inputs: int
    outputs: int
    lapack: bool

    @staticmethod
    def of(lowered: Lowered, compiled: Compiled) -> "MachineCode":
        """Return the code of a function that this process has compiled."""
        content, inputs, outputs = serialize_executable.serialize(compiled)
        module: Any = lowered.compiler_ir()
        text = io.BytesIO()
        module.operation.write_bytecode(text)
        lapack = b"lapack_" in text.getvalue()
        return MachineCode(zlib.compress(content, 1), inputs.num_leaves, outputs.num_leaves, lapack)

    def ready(self) -> Compiled:
        """Return the function, ready to run."""
        if self.lapack:
            # Tracing a function of LAPACK's makes it known to XLA.
            jax.jit(jnp.linalg.inv).lower(jnp.eye(1))
        inputs = jax.tree.structure(((0,) * self.inputs, {}))
        outputs = jax.tree.structure([0] * self.outputs)
        return serialize_executable.deserialize_and_load(zlib.decompress(self.content), inputs, outputs)


def all_ready(codes: Sequence[MachineCode]) -> list[Compiled]:
    """Return the parts of a program, each made ready on a core of its own."""
    with ThreadPoolExecutor(len(codes)) as beside:
        return list(beside.map(MachineCode.ready, codes))


def lowered(function: Callable[..., Any], *arguments: Any) -> Lowered:
    """Trace and lower a function of arrays for arguments like these, so that its code can be made bytes.

    It has a name that nothing else has: what JAX's own cache has compiled could not be made bytes again. And it lacks
    the names of what its instructions come from, which nobody reads: they are half of the code's size and a tenth of
    the time that loading it takes.
    """

    def program(*arrays: Any) -> Any:
        return function(*arrays)

    program.__name__ = f"program_{uuid.uuid4().hex}"
    made = jax.jit(program).lower(*arguments)
    module: Any = made.compiler_ir()
    with module.context:
        passmanager.PassManager.parse("builtin.module(strip-debuginfo)").run(module.operation)
    return made


@contextlib.contextmanager
def beside_the_cache_of_jax() -> Iterator[None]:
    """Keep what is compiled inside out of JAX's own cache: a file of ours has it."""
    before = getattr(jax.config, KEEPS)
    jax.config.update(KEEPS, NEVER)
    try:
        yield
    finally:
        jax.config.update(KEEPS, before)
