"""A solver that hands the whole run to `diffrax.diffeqsolve`."""

import equinox as eqx

from ..._types import AbstractSolver
from ...errors import InputError, check_whole, shown
from .solvers import Solver

DIFFRAX_METHODS = (
    "Bosh3",
    "Dopri5",
    "Dopri8",
    "Heun",
    "KenCarp3",
    "KenCarp4",
    "KenCarp5",
    "Kvaerno3",
    "Kvaerno4",
    "Kvaerno5",
    "Midpoint",
    "Ralston",
    "Tsit5",
)
"""Methods of diffrax for a whole run by `diffrax.diffeqsolve`: those for ODEs that estimate their error."""


def _kvaerno5() -> AbstractSolver:
    """Return the default method; diffrax is imported only for those who ask for it."""
    from diffrax import Kvaerno5

    return Kvaerno5()


class Diffrax(Solver):
    """The run by `diffrax.diffeqsolve`, with the smooth contact law and steps that end on touchdowns foreseen.

    Events are located afterwards, between the steps taken. Implicit methods have a root finder that knows the stiff
    forces, and sensitivities are under error control (docs/diffrax.md).

    **Arguments:**

    - ``method``: an instance such as ``diffrax.Kvaerno5()`` or ``diffrax.Tsit5()``; it must estimate its error.
    - ``max_steps``: room for so many steps, whose passing is a failed outcome.

    **Raises:** `InputError` for a method that does not estimate its error, and for ``max_steps`` below 1.

    **Example:** a design of any mechanism, ``jb.table2()`` too.

    >>> import diffrax
    >>> run = jb.simulate(jb.BarDrop(), solver=jb.Diffrax(diffrax.Tsit5()))
    >>> f"{float(run.peak_force):.0f} N"
    '1831 N'
    """

    method: AbstractSolver = eqx.field(static=True, default_factory=_kvaerno5)
    max_steps: int = eqx.field(static=True, default=16_384)

    def __check_init__(self) -> None:
        import diffrax

        known = tuple(getattr(diffrax, name) for name in DIFFRAX_METHODS)
        if not isinstance(self.method, (diffrax.AbstractERK, diffrax.AbstractDIRK, *known)):
            names = ", ".join(f"diffrax.{name}()" for name in DIFFRAX_METHODS)
            raise InputError(
                f"Diffrax({shown(self.method)}): not a method that solves an ODE and estimates its error; use {names}"
            )
        check_whole("max_steps", self.max_steps, 1)
