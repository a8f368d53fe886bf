"""How large the programs of a run and of its derivatives are: equations of their jaxprs, calls inlined, without those
whose results nothing uses, which JAX drops before it compiles.

`python -m benchmarks equations [--mechanism NAME] [--functions N] [--hlo] [--seconds]`. An equation counts to the loop
if it is in the program's largest `while`, which steps the run; all others run once, or once for each of a few instants,
and what a `scan` or a short loop repeats counts once. With ``--hlo`` each program is compiled, and the lines of its
optimised HLO are counted too. With ``--seconds`` it is traced and compiled first, and the processor time that this took
is printed last.
"""

import dataclasses
import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Annotated, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import typer
from jax.interpreters.partial_eval import dce_jaxpr

import jaxbuffer as jb
from jaxbuffer.mechanisms.mechanism import Request
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.programs.cache import Static
from jaxbuffer.run.request import request
from jaxbuffer.run.simulate import CHECKED
from jaxbuffer.run.stepper import run_of, stepped, stepper_of
from jaxbuffer.sensitivities.gradients import _gradients, _stepped

from .names import chosen

OWN = "/jaxbuffer/"


class Size(NamedTuple):
    """Equations of a program: in the ``loop`` that steps, and ``outside`` of it."""

    loop: int
    outside: int


@dataclasses.dataclass(frozen=True)
class Case:
    """A mechanism whose programs are counted: its ``design`` and ``scenario``."""

    design: Any
    scenario: Any

    @property
    def request(self) -> Request:
        """Return a request for a run of the default length."""
        mechanism = mechanism_of(self.design)
        given = request(mechanism, self.design, self.scenario, mechanism.duration(self.design))
        return jax.tree.map(lambda number: jnp.asarray(number, float), given)


def cases() -> dict[str, Case]:
    """Return what is counted, by name."""
    latched = {"latch.stiffness": 2000.0, "latch.damping": 50.0, "latch.strength": 50.0}
    return {
        "capture": Case(jb.table2(), jb.Scenario()),
        "docking": Case(jb.replace(jb.table2(), latched), jb.Scenario(start="free")),
        "capture3d": Case(jb.docking3d(), jb.Scenario3D()),
        "docking3d": Case(jb.replace(jb.docking3d(), latched), jb.Scenario3D(start="free")),
        "slider_crank": Case(jb.SliderCrank(), jb.SliderCrankScenario()),
        "bar_drop": Case(jb.BarDrop(), jb.BarDropScenario()),
        "tank_drop": Case(jb.TankDrop(), jb.TankDropScenario()),
    }


def programs(case: Case) -> dict[str, tuple[Callable[..., Any], tuple[Any, ...]]]:
    """Return the functions that are compiled, with arguments of theirs, by name: both parts of a run, `jax.grad` of its
    peak force, and both parts of its derivatives by the mechanism's own parameters."""
    given, mechanism = case.request, mechanism_of(case.design)
    between = jax.eval_shape(lambda given: stepped(given, CHECKED), given)

    def peak(design: Any) -> Any:
        moved = given._replace(parameters=(design, *given.parameters[1:]))
        return stepper_of(mechanism).run(moved).peak_force

    made: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
        "run, stepping": (lambda given: stepped(given, CHECKED), (given,)),
        "run, reading off": (run_of, (given, between)),
        "jax.grad": (jax.grad(peak), (given.parameters[0],)),
    }
    addresses = Static(mechanism.parameters(case.design))
    if not addresses.value:
        return made
    values = np.array([float(jb.get(case.design, path)) for path in addresses.value])
    numbers = (case.design, case.scenario, float(given.duration), 1e-6)
    inputs = jax.tree.map(lambda x: np.asarray(x, float), numbers)

    def moved(inputs: Any, values: Any) -> Any:
        return _stepped(mechanism, inputs, values, addresses, given.options.solver, None)

    def read(inputs: Any, values: Any, result: Any) -> Any:
        return _gradients.last(mechanism, inputs, values, addresses, given.options.solver, None, result)

    made["derivatives, stepping"] = (moved, (inputs, values))
    made["derivatives, reading off"] = (read, (inputs, values, jax.eval_shape(moved, inputs, values)))
    return made


def inner(equation: Any) -> Iterator[Any]:
    """Yield the jaxprs that an equation calls, repeats or chooses from."""
    for value in equation.params.values():
        for part in value if isinstance(value, (tuple, list)) else (value,):
            jaxpr = getattr(part, "jaxpr", part)
            if hasattr(jaxpr, "eqns"):
                yield jaxpr


def equations(jaxpr: Any) -> Iterator[Any]:
    """Yield all equations of a jaxpr but calls, loops and branches, whose own are yielded in their place."""
    for equation in jaxpr.eqns:
        parts = list(inner(equation))
        if parts:
            for part in parts:
                yield from equations(part)
        else:
            yield equation


def largest_loop(jaxpr: Any) -> Any:
    """Return the `while` equation with the most equations in it; None without one."""
    loops = list(_loops(jaxpr))
    return max(loops, key=_length, default=None)


def _loops(jaxpr: Any) -> Iterator[Any]:
    for equation in jaxpr.eqns:
        if equation.primitive.name == "while":
            yield equation
        else:
            for part in inner(equation):
                yield from _loops(part)


def _length(equation: Any) -> int:
    return sum(1 for part in inner(equation) for _ in equations(part))


def outside(jaxpr: Any, loop: Any, around: frozenset[str] = frozenset()) -> Iterator[frozenset[str]]:
    """Yield the functions that each equation outside the ``loop`` was traced in, beside those ``around`` it."""
    for equation in jaxpr.eqns:
        parts, names = list(inner(equation)), around | callers(equation)
        if not parts:
            yield names
        elif equation is not loop:
            for part in parts:
                yield from outside(part, loop, names)


def _used(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return the jaxpr of a function, without equations whose results nothing uses."""
    jaxpr = jax.make_jaxpr(function)(*arguments).jaxpr
    return dce_jaxpr(jaxpr, [True] * len(jaxpr.outvars))[0]


def size_of(function: Callable[..., Any], *arguments: Any, once: bool = False) -> Size:
    """Return the size of a function's program; ``once``: whether all of it runs once, as reading off does."""
    jaxpr = _used(function, *arguments)
    loop = None if once else largest_loop(jaxpr)
    return Size(0 if loop is None else _length(loop), sum(1 for _ in outside(jaxpr, loop)))


def callers(equation: Any) -> set[str]:
    """Return the functions of jaxbuffer that an equation was traced in, as ``file:function``."""
    traceback = equation.source_info.traceback
    if traceback is None:
        return set()
    return {
        f"{frame.file_name.rpartition(OWN)[2].removesuffix('.py')}:{frame.function_name}"
        for frame in traceback.frames
        if OWN in frame.file_name
    }


def by_function(function: Callable[..., Any], *arguments: Any, once: bool = False) -> Counter[str]:
    """Return how many of the equations that run once each function has, those that it calls included."""
    jaxpr = _used(function, *arguments)
    counts: Counter[str] = Counter()
    for equation in outside(jaxpr, None if once else largest_loop(jaxpr)):
        counts.update(equation)
    return counts


def hlo_lines(function: Callable[..., Any], *arguments: Any) -> int:
    """Return the lines of the optimised HLO of a function's program."""
    return len(jax.jit(function).lower(*arguments).compile().as_text().splitlines())


def compilation_seconds(function: Callable[..., Any], *arguments: Any) -> float:
    """Return the processor time of all threads in which a function's program is traced and compiled [s]."""
    start = time.process_time()
    jax.jit(function).lower(*arguments).compile()
    return time.process_time() - start


def main(
    mechanism: Annotated[list[str] | None, typer.Option(help="of a case; all unless given")] = None,
    program: Annotated[list[str] | None, typer.Option(help="of a program; all unless given")] = None,
    functions: Annotated[int, typer.Option(help="how many functions are listed below each program")] = 0,
    hlo: Annotated[bool, typer.Option(help="whether programs are compiled")] = False,
    seconds: Annotated[bool, typer.Option(help="whether compilation is timed")] = False,
) -> None:
    """Print the sizes."""
    jb.configure(cache=None)  # what is read from disk is not compiled
    known = cases()
    for name in chosen(mechanism, known, "mechanism"):
        for what, (function, arguments) in programs(known[name]).items():
            if program and what not in program:
                continue
            once = "reading off" in what
            # Before anything is traced: JAX keeps parts of that.
            took = f"{compilation_seconds(function, *arguments):8.1f} s" if seconds else ""
            size = size_of(function, *arguments, once=once)
            lines = f"{hlo_lines(function, *arguments):8}" if hlo else ""
            print(f"{name:14} {what:26} {size.loop:8} {size.outside:8}{lines}{took}", flush=True)
            if functions:
                for caller, count in by_function(function, *arguments, once=once).most_common(functions):
                    print(f"{'':16}{count:8}  {caller}")
