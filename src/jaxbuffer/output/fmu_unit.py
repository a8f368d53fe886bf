"""What a docking's Functional Mock-up Unit does in the tool that runs it: a `Plant` behind the variables of FMI 3.0.

`fmu` writes a unit whose class has this one and pythonfmu3's `Fmi3Slave` as its bases.
"""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..programs.process import configure
from ..run.plant import RUNNING, Loads, Observed, stepper
from ..study.designs import load_design

DESIGN, SETTINGS = "design.toml", "settings.json"
UNITS: dict[str, dict[str, int]] = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "s": {"s": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "m/s²": {"m": 1, "s": -2},
}
AXES = "xyz"
# Of poses and rates: the array, its units, and what its turns are called in the plane and in space.
MOTION = (("position", "m", "rad", ("angle", "rotation")), ("velocity", "m/s", "rad/s", ("spin", "spin")))


class PlantUnit:
    """A mechanism that is stepped by a co-simulation, with loads on its vehicles as inputs.

    A step of the co-simulation is one of `Plant.step`: the inputs are held over it. After the run's end all outputs
    stay as they are.
    """

    resources: str

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        configure()
        folder = Path(str(self.resources).removeprefix("file://"))
        design, (scenario, *_) = load_design(folder / DESIGN)
        self._plant = stepper(design, scenario, **json.loads((folder / SETTINGS).read_text()))
        force, moment = self._plant.loads()
        self._force, self._moment = np.zeros(force.shape), np.zeros(moment.shape)
        shapes = jax.eval_shape(lambda: self._plant.observe(self._plant.start()))
        self._seen: Observed = jax.tree.map(lambda it: np.zeros(it.shape, it.dtype), shapes)
        self._state: Any = None
        self._register()

    # --- variables ----------------------------------------------------------------------------------------------------

    def _register(self) -> None:
        """Register the inputs and outputs with pythonfmu3."""
        import pythonfmu3 as fmi  # an optional package, which stands in the unit itself

        mine: Any = self
        mine.register_units([fmi.Unit(name, **of) for name, of in UNITS.items()])
        time = fmi.Float64("time", causality=fmi.Fmi3Causality.independent, variability=fmi.Fmi3Variability.continuous)
        time.getter = partial(self._number, "time", ())
        mine.register_variable(time, nested=False)
        for k, body in enumerate(self._plant.pushed):
            for suffix, place in _components(self._force.shape[1:]):
                self._input(fmi, f"{body}.force{suffix}", "N", self._force, (k, *place))
            for suffix, place in _components(self._moment.shape[1:]):
                self._input(fmi, f"{body}.moment{suffix}", "N m", self._moment, (k, *place))
        for name, unit, of in self._outputs():
            self._output(fmi, fmi.Float64, name, of, unit=unit if unit in UNITS else None)
        for k, contact in enumerate(self._contacts):
            self._output(fmi, fmi.Int32, f"{contact}.touchdowns", partial(self._number, "touchdowns", k))
        self._output(fmi, fmi.Int32, "outcome", lambda: int(self._seen.code))
        named = lambda: "running" if (outcome := self._seen.outcome) is None else outcome.name  # noqa: E731
        self._output(fmi, fmi.String, "outcome_name", named)
        self._output(fmi, fmi.Boolean, "running", lambda: int(self._seen.code) == RUNNING)

    def _input(self, fmi: Any, name: str, unit: str, values: np.ndarray, place: tuple[int, ...]) -> None:
        """Register one component of a load."""
        variable = fmi.Float64(
            name,
            causality=fmi.Fmi3Causality.input,
            # Held over a step, as a zero-order hold is.
            variability=fmi.Fmi3Variability.discrete,
            unit=unit,
            getter=lambda: float(values[place]),
            setter=lambda value: values.__setitem__(place, float(value)),
        )
        self._add(variable)

    def _output(self, fmi: Any, kind: Any, name: str, of: Callable[[], Any], **more: Any) -> None:
        """Register an output of one number or text."""
        is_real = kind is fmi.Float64
        variability = fmi.Fmi3Variability.continuous if is_real else fmi.Fmi3Variability.discrete
        self._add(kind(name, causality=fmi.Fmi3Causality.output, variability=variability, getter=of, **more))

    def _add(self, variable: Any) -> None:
        mine: Any = self
        mine.register_variable(variable, nested=False)

    @property
    def _contacts(self) -> tuple[str, ...]:
        names = self._plant.mechanism.names(self._plant.parameters[0])
        return names.of_contacts(len(self._seen.contact_force))

    def _outputs(self) -> list[tuple[str, str, Callable[[], Any]]]:
        """Return name, unit and value of each output that is a real number."""
        of, rows = self._number, list[tuple[str, str, Callable[[], Any]]]()
        rows.append(("run_time", "s", partial(of, "time", ())))
        dimensions, turns = self._force.shape[1], self._moment.shape[1:]
        for array, of_place, of_turn, names in MOTION:
            suffixes = [(f".{array}{axis}", of_place) for axis, _ in _components((dimensions,))]
            suffixes += [(f".{names[dimensions == 3]}{axis}", of_turn) for axis, _ in _components(turns)]
            for k, body in enumerate(self._plant.bodies):
                each = enumerate(suffixes)
                rows += [(f"{body}{suffix}", unit, partial(of, array, (k, i))) for i, (suffix, unit) in each]
        for k, contact in enumerate(self._contacts):
            rows += [
                (f"{contact}.{array}", "N", partial(of, array, k)) for array in ("contact_force", "friction_force")
            ]
        units = self._plant.mechanism.names(self._plant.parameters[0]).others
        rows += [(name, units.get(name, ""), partial(of, "values", name)) for name in self._seen.values]
        rows.append(("peak_force", "N", partial(of, "peak_force", ())))
        largest = self._seen.largest
        return rows + [(f"largest.{name}", units.get(name, ""), partial(of, "largest", name)) for name in largest]

    def _number(self, name: str, place: Any) -> Any:
        """Return a number of what is seen: of an array at a place, of several by name."""
        return getattr(self._seen, name)[place].item()

    # --- the calls of a co-simulation ---------------------------------------------------------------------------------

    def enter_initialization_mode(self) -> None:
        """Begin the run."""
        self._state = self._plant.start()
        self._see(self._plant.observe(self._state))

    def do_step(self, current_time: float, step_size: float) -> Any:
        """Advance the run by a step of the co-simulation, with its inputs held."""
        from pythonfmu3 import Fmi3Status, Fmi3StepResult  # see `_register`

        mine: Any = self
        loads = Loads(jnp.asarray(self._force), jnp.asarray(self._moment))
        self._state, seen = self._plant.step(self._state, loads, step_size)
        self._see(seen)
        outcome = self._seen.outcome
        if outcome is not None and outcome.failed:
            mine.log(outcome.reason, Fmi3Status.error)
            return Fmi3StepResult(status=Fmi3Status.error)
        return Fmi3StepResult(status=Fmi3Status.ok)

    def _see(self, seen: Observed) -> None:
        self._seen = jax.tree.map(np.asarray, seen)

    def _get_fmu_state(self) -> dict[str, Any]:
        """Return all of the run, to which a master may come back."""
        return {"run": (self._state, self._seen), "held": (self._force.copy(), self._moment.copy())}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        """Go back to a state of before."""
        self._state, self._seen = state["run"]
        self._force[...], self._moment[...] = state["held"]


def _components(shape: tuple[int, ...]) -> list[tuple[str, tuple[int, ...]]]:
    """Return the suffix of each component's name, and its place; of a single number none."""
    if not shape:
        return [("", ())]
    return [(f".{axis}", (k,)) for k, axis in enumerate(AXES[: shape[0]])]
