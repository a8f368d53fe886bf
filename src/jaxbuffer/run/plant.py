"""`stepper`: a run that its caller advances, with forces and moments on the vehicles held over each step."""

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from .._types import Scalar
from ..elements.wrench import Wrench
from ..errors import InputError, check_choice, check_single, check_type, concrete, suggest
from ..fields import POSITIVE, Part, Portable
from ..hybrid import Diffrax, Options, Solver, solver_named
from ..hybrid.interval import Checkpoint, first_checkpoint, next_checkpoint
from ..mechanisms.assembled import Assembled
from ..mechanisms.mechanism import LIMITS, Mechanism, Parameters, Request, Tolerances
from ..mechanisms.outcome import RunOutcome, outcome_code
from ..mechanisms.registry import mechanism_of
from ..programs.cache import stored
from .request import DEFAULT_TOLERANCE, ONE_RUN, check_assembly, check_pair, options_of
from .stepper import events_options

ROOM = 8  # for events of one step in order; of later ones the largest values and the end are kept
AXES = ("inertial", "body")
STATES = "plant.start(), or what the step before returned"
RUNNING = -1  # the outcome's code of a run that has not ended


class Loads(NamedTuple):
    """Forces and moments on the bodies that are pushed, held over a step.

    ``force``: through each one's centre of mass, (bodies, 2) in the plane and (bodies, 3) in space [N]; ``moment``:
    (bodies,) in the plane, (bodies, 3) in space [N m].

    **Example:**

    >>> import jax.numpy as jnp
    >>> loads = jb.Loads(force=jnp.zeros((2, 2)), moment=jnp.asarray([0.05, 0.0]))
    >>> loads.moment.shape  # of the active and of the passive vehicle, as plant.loads(moment={"active": 0.05})
    (2,)
    """

    force: Float[Array, "bodies dimensions"]
    moment: Float[Array, "bodies *turns"]


class Observed(Portable):
    """What a step of a `Plant` returns: the run at the step's end, or at the run's end if that came first.

    - ``time`` [s].
    - ``position``: (bodies, 3) x, y and angle in the plane, (bodies, 6) x, y, z and rotation vector in space [m, rad].
    - ``velocity``: (bodies, 3) or (bodies, 6), the spin in inertial axes [m/s, rad/s].
    - ``contact_force``, ``friction_force``: of each contact that has impacts [N].
    - ``values``: the mechanism's other observables by name, such as the hinge's force.
    - ``peak_force``: largest force of any contact since the start [N], and ``largest``: largest values of the other
      observables since the start, by name; located within the steps.
    - ``touchdowns``: number of touchdowns of each contact since the start.
    - ``code``: the outcome's, -1 while the run goes on.

    **Example:**

    >>> plant = jb.stepper(jb.table2())
    >>> seen = plant.observe(plant.start())
    >>> print(seen.running, seen.outcome, f"{float(seen.velocity[0, 0]):g} m/s")
    True None 0.1 m/s
    """

    time: Float[Array, ""]
    position: Float[Array, "bodies positions"]
    velocity: Float[Array, "bodies velocities"]
    contact_force: Float[Array, " contacts"]
    friction_force: Float[Array, " contacts"]
    values: dict[str, Float[Array, ""]]
    peak_force: Float[Array, ""]
    largest: dict[str, Float[Array, ""]]
    touchdowns: Int[Array, " contacts"]
    code: Int[Array, ""]
    outcomes: type[RunOutcome] = eqx.field(static=True)

    @property
    def running(self) -> Bool[Array, ""]:
        """Return whether the run goes on."""
        return self.code == RUNNING

    @property
    def outcome(self) -> RunOutcome | None:
        """Return how the run ended, None while it goes on."""
        return None if int(self.code) == RUNNING else self.outcomes(int(self.code))


@dataclasses.dataclass(frozen=True)
class _Pushed:
    """Assembles a mechanism with loads on some of its ``bodies``, by their numbers and names."""

    mechanism: Mechanism
    bodies: tuple[tuple[int, str], ...]
    turning: bool

    def __call__(self, design: Part, scenario: Part, stabilisation: Scalar, loads: Any) -> Assembled:
        system = self.mechanism.system(design, scenario, stabilisation)
        assert isinstance(system, Assembled)
        wrenches = (
            Wrench(body, force, moment, self.turning, name=f"{name} push")
            for (body, name), (force, moment) in zip(self.bodies, loads, strict=True)
        )
        return dataclasses.replace(system, elements=(*system.elements, *wrenches))


class Plant(eqx.Module):
    """A mechanism that a controller, or another simulator, advances step by step; `stepper` makes one.

    `start` and `step` are pure functions of arrays: they work under `jit`, `vmap`, `grad` and in `lax.scan`, and have
    derivatives by loads, states and the numbers of the design and scenario, under error control.

    - ``parameters``: design, scenario and Baumgarte's gain [1/s].
    - ``pushed``: the names of the bodies that loads act on, in their order.
    - ``shapes``: of a force and of a moment on one of them.

    **Example:** a quarter of a second in one program, with a moment against the angle of the active vehicle.

    >>> import jax, jax.numpy as jnp
    >>> plant = jb.stepper(jb.table2())
    >>> def advance(carry, _):
    ...     state, angle = carry
    ...     moment = jnp.stack([-0.5 * angle, jnp.zeros(())])
    ...     state, seen = plant.step(state, jb.Loads(jnp.zeros((2, 2)), moment), 0.025)
    ...     return (state, seen.position[0, 2]), seen.peak_force
    >>> _, peaks = jax.lax.scan(advance, (plant.start(), jnp.zeros(())), length=10)
    >>> f"{float(peaks[-1]):.2f} N"
    '141.58 N'
    """

    parameters: Parameters
    tolerances: Tolerances
    options: Options
    mechanism: Mechanism = eqx.field(static=True)
    pushed: tuple[str, ...] = eqx.field(static=True)
    axes: str = eqx.field(static=True)
    shapes: tuple[tuple[int, ...], tuple[int, ...]] = eqx.field(static=True)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Return the bodies' names, in the order of positions and velocities."""
        return self.mechanism.names(self.parameters[0]).bodies

    def loads(self, force: Mapping[str, Any] | None = None, moment: Mapping[str, Any] | None = None) -> Loads:
        """Return loads from those of single bodies, zero where none is given.

        **Arguments:** ``force``: by the body's name, (2,) in the plane and (3,) in space [N]; ``moment``: by name, a
        number in the plane and (3,) in space [N m].

        **Raises:** `InputError` for a body that is not ``pushed``, and for a wrong shape.
        """
        filled = (
            self._filled(what, shape, given or {})
            for what, shape, given in zip(("force", "moment"), self.shapes, (force, moment), strict=True)
        )
        return Loads(*filled)

    def _filled(self, what: str, shape: tuple[int, ...], given: Mapping[str, Any]) -> Array:
        for name, value in given.items():
            if name not in self.pushed:
                raise InputError(
                    f"{what}: nothing pushes a body {name!r}; there are {', '.join(self.pushed)}"
                    f"{suggest(name, self.pushed)}"
                )
            if np.shape(value) != shape:
                raise InputError(f"{what} of {name} has shape {np.shape(value)}; it needs {shape}")
        return jnp.stack([jnp.asarray(given.get(name, np.zeros(shape)), float) for name in self.pushed])

    def start(self) -> Checkpoint:
        """Return the state of the run at t = 0. Hand it on to `step`; it is a tree of arrays, to be read by none but
        that."""
        return _start(self)

    def observe(self, state: Checkpoint) -> Observed:
        """Return what is observed of a state, at the start say, without loads."""
        check_type("state", state, Checkpoint, STATES)
        return _observe(self, state)

    def step(self, state: Checkpoint, loads: Loads | None, length: Scalar) -> tuple[Checkpoint, Observed]:
        """Advance a run, and return its state and what is observed of it at the end of the step.

        The step is solved as any run is, event by event and under its error control, whatever its length. A run that
        has ended stays as it is.

        **Arguments:** ``state``: of `start` or of the step before; ``loads``: see `loads`, None for none; ``length``
        [s].

        **Raises:** `InputError` for a length or a load that is out of range.
        """
        check_single("length", length, "s", "one number", **POSITIVE)
        loads = self.loads() if loads is None else loads
        check_type("state", state, Checkpoint, STATES)
        check_type("loads", loads, Loads, "plant.loads(force={...}, moment={...})")
        for what, value, shape in zip(("force", "moment"), loads, self.shapes, strict=True):
            wanted = (len(self.pushed), *shape)
            if np.shape(value) != wanted:
                raise InputError(f"loads: {what} has shape {np.shape(value)}; it needs {wanted}")
            known = concrete(value)
            if known is not None and not np.all(np.isfinite(known)):
                raise InputError(f"loads: {what} must be finite")
        return _step(self, state, Loads(*(jnp.asarray(it, float) for it in loads)), jnp.asarray(length, float))

    @property
    def _build(self) -> _Pushed:
        numbers = tuple((self.bodies.index(name), name) for name in self.pushed)
        return _Pushed(self.mechanism, numbers, self.axes == "body")

    @property
    def _request(self) -> Request:
        return Request(self.mechanism, self.parameters, 1.0, self.tolerances, self.options)


def stepper(
    design: Part,
    scenario: Part | None = None,
    *,
    pushed: tuple[str, ...] | None = None,
    axes: str = "inertial",
    solver: Solver | str | None = None,
    rtol: Scalar = DEFAULT_TOLERANCE,
    atol: Scalar | None = None,
    max_steps: int = 200_000,
    stabilisation: Scalar = 20.0,
) -> Plant:
    """Return a mechanism as a `Plant`, which its caller advances by time steps of its own, with forces and moments held
    over each (zero-order hold).

    **Arguments:**

    - ``design``: of a mechanism of bodies, such as ``jb.table2()``.
    - ``scenario`` (default: the mechanism's own): the start.
    - ``pushed``: names of the bodies that loads act on (default: the mechanism's vehicles).
    - ``axes``: along which loads act: "inertial", or "body" for axes that turn with the body.
    - ``solver``, ``rtol``, ``atol``, ``stabilisation``: as of `simulate`.
    - ``max_steps``: of the integrator in one step, whose passing is a failed outcome.

    **Returns:** a `Plant`.

    **Raises:** `InputError` for values out of range, and for a mechanism that is not stepped from event to event.

    **Example:** a moment of 0.05 N m on the active vehicle for 0.1 s, and then nothing.

    >>> plant = jb.stepper(jb.table2(), jb.Scenario(approach_speed=0.1))
    >>> state, seen = plant.step(plant.start(), plant.loads(moment={"active": 0.05}), 0.1)
    >>> state, seen = plant.step(state, None, 8.0)
    >>> print(f"{seen.outcome.name} at {float(seen.time):.4f} s, at most {float(seen.peak_force):.2f} N")
    captured at 0.7080 s, at most 254.01 N
    """
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    atol = rtol if atol is None else atol
    one = ONE_RUN.format(mechanism.view.run_name)
    for name, value, unit in (("rtol", rtol, "-"), ("atol", atol, "-"), ("stabilisation", stabilisation, "1/s")):
        check_single(name, value, unit, one, **LIMITS[name])
    check_choice("axes", axes, AXES)
    solver = solver_named(solver)
    if mechanism.stepper is not None or isinstance(solver, Diffrax):
        raise InputError("stepper needs a mechanism, and a solver, that step from event to event")
    names = mechanism.names(design).bodies
    chosen = tuple(pushed) if pushed is not None else mechanism.defaults.pushed or names
    for name in chosen:
        check_choice("pushed", name, names)
    options = dataclasses.replace(options_of(max_steps, ROOM), solver=solver)
    if not any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves((design, scenario))):
        check_assembly(mechanism, design, scenario, stabilisation)
    parameters = (design, scenario, stabilisation)
    return Plant(parameters, (rtol, atol), options, mechanism, chosen, axes, _shapes(mechanism, parameters))


def _shapes(mechanism: Mechanism, parameters: Parameters) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the shapes of a force and of a moment on one body. **Raises:** `InputError` for a mechanism that is not
    assembled from bodies."""
    dimensions = []

    def look() -> Array:
        system = mechanism.system(*parameters)
        if isinstance(system, Assembled):
            dimensions.append(system.system.basis.dimensions)
        return jnp.zeros(())

    jax.eval_shape(look)  # nothing is computed
    if not dimensions:
        raise InputError(f"stepper needs a mechanism assembled from bodies, which {mechanism.name} is not")
    return ((3,), (3,)) if dimensions[0] == 3 else ((2,), ())


@functools.partial(stored, what="a stepper's start")
def _start(plant: Plant) -> Checkpoint:
    build = plant._build
    parameters = (*plant.parameters, _scalars(plant.loads()))
    return first_checkpoint(build, parameters, events_options(plant._request), plant._request.allowed)


@functools.partial(stored, what="what a stepper sees")
def _observe(plant: Plant, state: Checkpoint) -> Observed:
    return _observed(plant, plant._build(*plant.parameters, _scalars(plant.loads())), state)


@functools.partial(stored, seconds=20.0, what="a stepper's step")
def _step(plant: Plant, state: Checkpoint, loads: Loads, length: Array) -> tuple[Checkpoint, Observed]:
    build, options = plant._build, events_options(plant._request)
    parameters = (*plant.parameters, _scalars(loads))
    system = build(*parameters)
    # A load matters that changes the momentum within the step by what it is of the order of.
    size = jax.lax.stop_gradient(system.energy_scale / system.typical_speed / length)
    none = jax.tree.map(lambda _: None, plant.parameters)
    sizes = (*none, jax.tree.map(lambda _: size, parameters[-1]))
    after = next_checkpoint(build, parameters, state, length, options, sizes)
    return after, _observed(plant, system, after)


def _scalars(loads: Loads) -> Any:
    """Return the loads of each body as its components, number by number."""
    return tuple(
        (tuple(force), tuple(jnp.atleast_1d(moment))) for force, moment in zip(loads.force, loads.moment, strict=True)
    )


def _observed(plant: Plant, system: Assembled, state: Checkpoint) -> Observed:
    at, active = system.evaluate(state.state), state.loop.active
    snapshot, moving = system.snapshot_at(at, active), at.kin.velocity_order.placements
    contacts = system.impact_contacts
    outcomes = plant.mechanism.outcomes
    code = jnp.where(state.running, RUNNING, outcome_code(outcomes, system.end_outcomes, state.loop.status))
    numbers = {
        "time": state.time,
        "position": at.kin.poses(),
        "velocity": moving(at.kin.v),
        "contact_force": snapshot.normal,
        "friction_force": snapshot.friction,
        "values": dict(snapshot.others),
        "peak_force": jnp.max(state.largest[:contacts], initial=0.0),
        "largest": dict(zip(system.observed[contacts:], state.largest[contacts:], strict=True)),
    }
    known = jnp.where(code < outcomes["failed_steps"], 1.0, jnp.nan)
    numbers = jax.tree.map(lambda it: it * known, numbers)
    return Observed(**numbers, touchdowns=state.touchdowns[:contacts], code=code, outcomes=outcomes)
