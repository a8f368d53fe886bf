"""A compiled function taken apart into plain descriptions and machine code, and put together again.

JAX's own way (`jax.experimental.serialize_executable`) is a pickle. What it holds, for a function of arrays on one
device, is little: shapes and types of arguments and results, which arguments are used, and what XLA serialises itself.
"""

from typing import Any

import jax
import numpy as np
from jax.core import ShapedArray
from jax.stages import ArgInfo, Compiled

Description = dict[str, Any]


class CannotKeep(ValueError):
    """A compiled function that is more than this can put together."""


def taken_apart(compiled: Compiled) -> tuple[Description, bytes]:
    """What `put_together` needs; raises `CannotKeep` for callbacks, effects, several devices and the like."""
    unloaded = compiled._executable._unloaded_executable  # type: ignore[attr-defined]
    if unloaded.committed or {*unloaded.input_shardings, *unloaded.output_shardings} - {_device()}:
        raise CannotKeep("it runs elsewhere than on the first device")
    if unloaded.mut or unloaded.host_callbacks or unloaded.keepalive or compiled._params.const_args:
        raise CannotKeep("it holds more than code")
    if unloaded.ordered_effects or unloaded.unordered_effects or any(unloaded.dispatch_in_layouts):
        raise CannotKeep("it has effects, or layouts of its own")
    description = {
        "name": unloaded.name,
        "arguments": [_shown(info._aval) for info in jax.tree.leaves(compiled.args_info)],
        "used": sorted(unloaded.kept_var_idx),
        "results": [_shown(value) for value in unloaded.output_avals],
    }
    return description, unloaded.xla_executable.serialize()


def put_together(description: Description, code: bytes) -> Compiled:
    """The compiled function again. XLA loads the code as it is: it must be known to be what `taken_apart` gave."""
    from jax._src.interpreters import pxla
    from jax._src.lax.linalg import initialize_lapack
    from jax._src.lib import xla_client

    initialize_lapack()  # else done where such a call is traced: code that solves equations would end the process
    arguments = [_value(shown) for shown in description["arguments"]]
    used, results = description["used"], [_value(shown) for shown in description["results"]]
    inputs = [arguments[k] for k in used]
    device = jax.devices()[0]
    devices = xla_client.DeviceList((device,))
    loaded = device.client.deserialize_executable(code, executable_devices=devices)
    layouts = pxla._get_layouts_from_executable(loaded, [None] * len(inputs), [None] * len(results), 0, inputs, results)
    executable = pxla.UnloadedMeshExecutable(
        xla_executable=loaded,
        device_list=devices,
        backend=device.client,
        input_avals=inputs,
        input_shardings=[_device()] * len(inputs),
        output_avals=results,
        output_shardings=[_device()] * len(results),
        committed=False,
        name=description["name"],
        unordered_effects=[],
        ordered_effects=[],
        keepalive=[],
        host_callbacks=[],
        kept_var_idx=set(used),
        mut=None,
        xla_in_layouts=layouts[0],
        dispatch_in_layouts=[None] * len(inputs),
        xla_out_layouts=layouts[1],
        all_args_info=None,
        pgle_profiler=None,
    ).load()
    infos = tuple(ArgInfo(value, False) for value in arguments)
    return Compiled(executable, [], (infos, {}), jax.tree.structure([0] * len(results)))


def _device() -> Any:
    """The placement of every array: the first device's own memory."""
    device = jax.devices()[0]
    return jax.sharding.SingleDeviceSharding(device, memory_kind=device.default_memory().kind)


def _shown(value: Any) -> list[Any]:
    if type(value) is not ShapedArray:
        raise CannotKeep(f"{value} is not an array")
    return [list(value.shape), np.dtype(value.dtype).str, bool(value.weak_type)]


def _value(shown: list[Any]) -> ShapedArray:
    shape, kind, weak = shown
    return ShapedArray(tuple(shape), np.dtype(kind), weak_type=weak)
