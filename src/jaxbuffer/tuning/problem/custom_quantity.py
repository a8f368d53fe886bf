"""A quantity of one's own: a Python function of a run's quantities, differentiated by JAX."""

import dataclasses
import functools
import inspect
import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...errors import InputError, shown, suggest
from ...fields.units import check_unit
from ...mechanisms.quantity import Catalogue, Quantity
from ...mechanisms.run import Run
from ...programs.identity import code_hash

EXAMPLE = "CustomQuantity(lambda peak_force, stroke: peak_force * stroke, 'N m')"
RESERVED = frozenset(  # words of a study's tables and keys of a tuning's records
    [
        *(
            "require_success",
            "impacts",
            "over",
            "level",
            "tolerance",
            "evaluation",
            "stage",
            "search",
            "step",
            "accepted",
        ),
        *("objective", "feasible", "excess", "radius", "residual", "status", "captures", "values", "outcome"),
        *("succeeded", "margin", "first_peak", "unit", "obstacle"),
    ]
)


@dataclasses.dataclass(frozen=True)
class CustomQuantity:
    """A quantity of your own, for objectives and limits: a function of those in the mechanism's catalogue.

    JAX differentiates the function, and the chain rule does the rest with the gradients that a run has anyway.

    **Arguments:**

    - ``function``: of quantities, which its parameters name (`jaxbuffer fields KIND` lists them), each a number in its
      unit; it returns one number, computed with ``jax.numpy`` and without chance. To go to another process it must be
      written with def in a module, for a lambda cannot be pickled.
    - ``unit``: of what it returns, "-" for none.
    - ``description``: what it is, in a line.

    **Raises:** `InputError` for a function that JAX can't trace, that returns something else than one real number, that
    changes from call to call or whose derivative by one of its parameters is zero everywhere, and for unknown units.

    **Example:** force times stroke; a capture's tuning then lowers it.

    >>> effort = jb.CustomQuantity(lambda peak_force, stroke: peak_force * stroke, "N m")
    >>> scenarios, variables = [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    >>> problem = jb.Problem(
    ...     jb.table2(), scenarios, variables, jb.Objective({"effort": 1.0}), quantities={"effort": effort}
    ... )
    >>> effort.parameters, problem.names[-1]
    (('peak_force', 'stroke'), 'effort')
    """

    function: Callable[..., Any]
    unit: str
    description: str = ""

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"custom quantity's function = {shown(self.function)} is not a function; write {EXAMPLE}")
        check_unit(f"unit of {self.label}", self.unit)
        if not isinstance(self.description, str):
            raise InputError(f"description of {self.label} = {shown(self.description)} is not a text")
        if not self.parameters:
            raise InputError(f"{self.label} has no parameter; name quantities: {EXAMPLE}")
        for parameter in inspect.signature(self.function).parameters.values():
            if parameter.kind not in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
                raise InputError(f"{self.label}: its parameter {parameter} names no quantity; write {EXAMPLE}")
            if parameter.default is not parameter.empty:
                remedy = "each parameter is a quantity of the run; write constants into the function"
                raise InputError(f"{self.label}: its parameter {parameter.name} has a default value; {remedy}")
        check_traced(self)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the arguments only, because what is made of them contains compiled code."""
        return type(self), (self.function, self.unit, self.description)

    @functools.cached_property
    def parameters(self) -> tuple[str, ...]:
        """Return the names of the quantities that it is made of."""
        try:
            return tuple(inspect.signature(self.function).parameters)
        except (TypeError, ValueError):
            raise InputError(f"{self.label}: its parameters are not known; write it with def or lambda") from None

    @property
    def label(self) -> str:
        """Return what messages call it: "function effort"."""
        name = getattr(self.function, "__name__", type(self.function).__name__)
        return name if name == "<lambda>" else f"function {name}"

    @property
    def signature(self) -> str:
        """Return what it is made of: "effort(peak_force, stroke)"."""
        return f"{self.label.removeprefix('function ')}({', '.join(self.parameters)})"

    def value(self, values: Sequence[Any]) -> Float[Array, ""]:
        """Return its value from those of its parameters, in their order, each in its unit."""
        result = self.function(**dict(zip(self.parameters, values, strict=True)))
        # `bool` is a kind of `int` in Python.
        if not isinstance(result, (int, float, np.number, np.ndarray, jax.Array)) or isinstance(result, bool):
            raise InputError(f"{self.label} returns {shown(result)}, not a number")
        if jnp.shape(result) != ():
            raise InputError(f"{self.label} returns an array of the shape {jnp.shape(result)}, not one number")
        if not jnp.issubdtype(jnp.result_type(result), jnp.number) or jnp.iscomplexobj(result):
            raise InputError(f"{self.label} returns a number of the type {jnp.result_type(result)}, not a real one")
        return jnp.asarray(result, float)

    @functools.cached_property
    def linearised(self) -> Callable[[Array], tuple[Array, Array]]:
        """Return the compiled function from values (n, parameters) to results (n,) and derivatives (n, parameters)."""

        def one(values: Float[Array, " parameters"]) -> tuple[Array, Array]:
            return self.value(list(values)), jax.jacfwd(lambda at: self.value(list(at)))(values)

        return jax.jit(jax.vmap(one))

    def as_quantity(self, name: str) -> Quantity:
        """Return it as an entry of a catalogue."""

        def of(run: Run) -> Float[Array, ""]:
            catalogue = run.mechanism.quantities
            return self.value([jnp.asarray(catalogue[parameter].of(run)) for parameter in self.parameters])

        description = self.description or self.signature
        # Signed, since a function of the user's own may return anything: no bound may rely on its being positive.
        return Quantity(self.unit, of, description, name.replace("_", " "), signed=True, tuned=True)

    @property
    def identity(self) -> str:
        """Return a hash of the function and of all that it reads: the same in every process with this Python."""
        return code_hash(self.function)


def check_traced(custom: CustomQuantity) -> None:
    """Raise `InputError` for a function that JAX can't trace or differentiate, or that is another one at each call."""
    jaxpr = _traced(custom)
    # A function that depends on chance, time or a state is traced to other equations, or to other constants.
    again = _traced(custom)
    consts = zip(jaxpr.consts, again.consts, strict=False)
    if str(jaxpr) != str(again) or not all(np.array_equal(a, b, equal_nan=True) for a, b in consts):
        raise InputError(f"{custom.label} is another one at each call; it must not depend on chance, time or a state")
    count = len(custom.parameters)
    # Which parameters each value of the traced derivative depends on, followed from equation to equation.
    reached: dict[int, frozenset[int]] = {id(v): frozenset([k]) for k, v in enumerate(jaxpr.jaxpr.invars[count:])}
    for equation in jaxpr.jaxpr.eqns:
        through = frozenset().union(*(reached.get(id(v), frozenset()) for v in equation.invars))
        reached |= {id(v): through for v in equation.outvars}
    by = reached.get(id(jaxpr.jaxpr.outvars[1]), frozenset())
    lost = [name for k, name in enumerate(custom.parameters) if k not in by]
    if lost:
        cause = "it is not used, or only rounded, compared or behind stop_gradient"
        raise InputError(f"{custom.label}: its derivative by {lost[0]} is zero everywhere: {cause}")


def _traced(custom: CustomQuantity) -> Any:
    """Return the function and its derivative as JAX sees them."""
    numbers = [jax.ShapeDtypeStruct((), jnp.result_type(float))] * len(custom.parameters)

    def both(values: list[Array], changes: list[Array]) -> tuple[Array, Array]:
        pair: tuple[Array, Array] = jax.jvp(lambda *args: custom.value(args), values, changes)
        return pair

    try:
        return jax.make_jaxpr(both)(numbers, numbers)
    except InputError:
        raise
    except (jax.errors.ConcretizationTypeError, jax.errors.TracerArrayConversionError) as error:
        remedy = "float(), int(), if, math and numpy do; write jax.numpy and jax.numpy.where"
        raise InputError(f"{custom.label} takes a number out of JAX{_line(custom, error)}: {remedy}") from None
    except Exception as error:  # the user's own code
        raise InputError(f"{custom.label} {raised(error)}{_line(custom, error)}") from None


def raised(error: BaseException) -> str:
    """Return what an error in somebody's code says: "raises KeyError: 'a'"."""
    first = next(iter(str(error).splitlines()), "")
    return f"raises {type(error).__name__}{f': {first}' if first else ''}"[:200]


def _line(custom: CustomQuantity, error: BaseException) -> str:
    """Return where in the function's file an error came about, as text."""
    code = getattr(inspect.unwrap(custom.function), "__code__", None)
    line = None if code is None else line_in(code.co_filename, error)
    return "" if line is None else f" in line {line}"


def line_in(file: str, error: BaseException) -> int | None:
    """Return the line of a file that was the last one there on the way to an error, None for none."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    return lines[-1] if lines else None


def check_custom_quantities(quantities: Any, catalogue: Catalogue) -> dict[str, CustomQuantity]:
    """Check the own quantities of a problem. **Raises:** `InputError` for names and parameters that can't be."""
    if not isinstance(quantities, Mapping):
        raise InputError(f"quantities = {shown(quantities)} is not a mapping; write quantities={{'effort': {EXAMPLE}}}")
    for name, custom in quantities.items():
        check_name(name, catalogue)
        if not isinstance(custom, CustomQuantity):
            raise InputError(f"quantities.{name} = {shown(custom)} is not a CustomQuantity; write {EXAMPLE}")
        for parameter in custom.parameters:
            if parameter not in catalogue:
                hint = suggest(parameter, catalogue)
                raise InputError(f"quantities.{name}: {custom.label} asks for {parameter}, which is unknown{hint}")
    return dict(quantities)


def check_name(name: Any, catalogue: Catalogue) -> None:
    """Raise `InputError` for what is no name for a quantity, or one that is taken."""
    if not isinstance(name, str) or not name.isidentifier():
        raise InputError(f"quantities: {shown(name)} is no name; write letters, digits and _, effort say")
    if name in catalogue or name in RESERVED:
        raise InputError(f"quantities.{name}: the name is taken; choose another one")
