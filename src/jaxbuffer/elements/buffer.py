"""A real buffer along the cylinder: preload, quadratic damping, rebound factor, friction and measured curves.

By the stroke s and its rate ṡ it pushes the probe out with F_s(s) + F_d(ṡ) + F_f tanh(ṡ/v_f) (M171 to M173).
"""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..fields import MonotoneCubic
from ..multibody import AxialSpringDamper, Kinematics, Load, SpringDirection, load_at
from .element import ROUNDED_LENGTH, Closed, Element, Own
from .picture import Level, Panel, PanelCurve
from .report import EnergyShare, Report
from .telling import SummaryRow, largest


class BufferForce(AxialSpringDamper):
    """The axial force of a buffer that is more than a linear spring and damper.

    Its stroke is that of `AxialSpringDamper`: s = l_0 - L. What is None is not there.

    - ``spring_curve``, ``damper_curve``: measured F_s(s) and F_d(ṡ) [N], in place of stiffness and damping (M173).
    - ``preload``: F_0 [N], which builds up within ``preload_length`` [m] (M171).
    - ``quadratic``: c_2 of the damper's F = c ṡ + c_2 ṡ² [N s²/m²] (M172).
    - ``rebound_factor``: the damper's force on the way out over that on the way in [-] (M172).
    - ``friction``: F_f [N], which builds up within ``friction_speed`` [m/s] (M172).
    """

    spring_curve: MonotoneCubic | None = None
    damper_curve: MonotoneCubic | None = None
    preload: Scalar | None = None
    preload_length: Scalar = 1e-4
    quadratic: Scalar | None = None
    rebound_factor: Scalar | None = None
    friction: Scalar | None = None
    friction_speed: Scalar = 1e-3

    def stroke(self, kin: Kinematics) -> tuple[Scalar, Scalar]:
        """Return s [m] and ṡ [m/s]."""
        at = self.state(kin)
        return self.free_length - at.length, -at.rate

    def spring_force(self, stroke: Scalar) -> Scalar:
        """Return F_s [N] (M171, M173)."""
        force = self.stiffness * stroke if self.spring_curve is None else self.spring_curve.value(stroke)
        if self.preload is not None:
            # A preload that acted at once would jump where the stroke changes sign; it is reached over a length (M171).
            force = force + self.preload * stroke / jnp.sqrt(stroke**2 + self.preload_length**2)
        return force

    def spring_energy(self, stroke: Scalar) -> Scalar:
        """Return the energy stored in the spring [J], the integral of F_s."""
        curve = self.spring_curve
        energy = 0.5 * self.stiffness * stroke**2 if curve is None else curve.integral(stroke)
        if self.preload is not None:
            length = self.preload_length
            energy = energy + self.preload * (jnp.sqrt(stroke**2 + length**2) - length)
        return energy

    def damper_force(self, speed: Scalar) -> Scalar:
        """Return F_d [N] (M172, M173)."""
        size = jnp.where(speed < 0.0, -speed, speed)  # whose derivative at zero, unlike that of abs, is 1
        force = self.damping * size if self.damper_curve is None else self.damper_curve.value(size)
        if self.quadratic is not None:
            force = force + self.quadratic * size * size
        outwards = force if self.rebound_factor is None else self.rebound_factor * force
        return jnp.where(speed < 0.0, -outwards, force)

    def friction_force(self, speed: Scalar) -> Scalar:
        """Return F_f tanh(ṡ/v_f) [N] (M172)."""
        # Coulomb's friction jumps where the motion turns round; regularised by a speed it is smooth there (M172).
        return 0.0 if self.friction is None else self.friction * jnp.tanh(speed / self.friction_speed)

    def friction_loss(self, kin: Kinematics) -> Scalar:
        """Return the power lost in friction [W]."""
        _, speed = self.stroke(kin)
        return self.friction_force(speed) * speed

    # --- as a force element -------------------------------------------------------------------------------------------

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        # Neither force need be linear: implicit steps take its slope at this stroke and speed.
        direction = super().springs(kin)[0]
        stroke, speed = (jnp.asarray(x, float) for x in self.stroke(kin))
        one = jnp.ones(())
        stiffness = jax.jvp(lambda s: jnp.asarray(self.spring_force(s)), (stroke,), (one,))[1]
        dissipative = lambda v: jnp.asarray(self.damper_force(v) + self.friction_force(v))  # noqa: E731
        return (direction._replace(stiffness=stiffness, damping=jax.jvp(dissipative, (speed,), (one,))[1]),)

    def tension(self, kin: Kinematics) -> Scalar:
        stroke, speed = self.stroke(kin)
        return -(self.spring_force(stroke) + self.damper_force(speed) + self.friction_force(speed))

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        at = self.state(kin)
        pull = at.along * self.tension(kin)
        return load_at(at.first, pull), load_at(at.second, -pull)

    def energy(self, kin: Kinematics) -> Scalar:
        return self.spring_energy(self.stroke(kin)[0])

    def dissipation(self, kin: Kinematics) -> Scalar:
        _, speed = self.stroke(kin)
        return self.damper_force(speed) * speed + self.friction_loss(kin)


class BufferState(NamedTuple):
    """A buffer at one instant: the bodies' ``kin``, its ``stroke`` s = l_0 - L [m] and its ``stroke_rate`` [m/s]."""

    kin: Kinematics
    stroke: Scalar
    stroke_rate: Scalar


class Buffer(Element):
    """A spring and damper along a guide, whose force and stroke are watched, and whose way may come to its end.

    - ``force``: the axial force, an `AxialSpringDamper` or a `BufferForce`.
    - ``longest_stroke``: at which the run ends, "bottomed" [m]; None: the way has no end.
    - ``name``: of its force, with ``_force`` added; ``stroke``: of its stroke, and of its `extension`.
    - ``stored_in``, ``lost_in``, ``rubbed_in``: names of the energies that it stores and loses in damper and friction.
    """

    force: AxialSpringDamper
    longest_stroke: Scalar | None = None
    name: str = eqx.field(static=True, default="buffer")
    stroke: str = eqx.field(static=True, default="stroke")
    stored_in: str = eqx.field(static=True, default="spring")
    lost_in: str = eqx.field(static=True, default="axial_damper")
    rubbed_in: str = eqx.field(static=True, default="buffer_friction")

    @property
    def stiffness_at_rest(self) -> Scalar:
        """Return the stiffness of its spring at its free length [N/m]."""
        curve = self.force.spring_curve if isinstance(self.force, BufferForce) else None
        # A measured curve begins at (0, 0), its first point: the secant from there to the next one is about its slope.
        return self.force.stiffness if curve is None else curve.values[1] / curve.places[1]

    @property
    def extension(self) -> str:
        """Return the name of its extension, -s: "extension" beside "stroke", "left_extension" beside "left_stroke"."""
        return "extension" if self.stroke == "stroke" else f"{self.stroke.removesuffix('_stroke')}_extension"

    @property
    def rubs(self) -> bool:
        """Return whether it has friction."""
        return isinstance(self.force, BufferForce) and self.force.friction is not None

    def evaluate(self, kin: Kinematics, own: Own) -> BufferState:
        at = self.force.state(kin)
        return BufferState(kin, self.force.free_length - at.length, -at.rate)

    def loads(self, at: BufferState, closed: Closed) -> tuple[Load, ...]:
        return self.force.loads(at.kin)

    def stored(self, at: BufferState, closed: Closed) -> dict[str, Scalar]:
        return {self.stored_in: self.force.energy(at.kin)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (self.lost_in, self.rubbed_in) if self.rubs else (self.lost_in,)

    def losses(self, at: BufferState, closed: Closed) -> dict[str, Scalar]:
        lost = self.force.dissipation(at.kin)
        if not isinstance(self.force, BufferForce) or self.force.friction is None:
            return {self.lost_in: lost}
        # The dissipation of the force is both losses together; they are listed apart.
        rubbed = self.force.friction_loss(at.kin)
        return {self.lost_in: lost - rubbed, self.rubbed_in: rubbed}

    @property
    def outcomes(self) -> tuple[str, ...]:
        return () if self.longest_stroke is None else ("bottomed",)

    def guards(self, at: BufferState) -> list[Scalar]:
        return [] if self.longest_stroke is None else [at.stroke - self.longest_stroke]

    @property
    def observed(self) -> tuple[str, ...]:
        return (f"{self.name}_force", self.stroke, self.extension)

    def observables(self, at: BufferState, closed: Closed) -> dict[str, Scalar]:
        force = jnp.abs(self.force.tension(at.kin))
        return {f"{self.name}_force": force, self.stroke: at.stroke, self.extension: -at.stroke}

    @property
    def lower_bounds(self) -> dict[str, float]:
        return {self.extension: 0.0}  # of a rod that never goes out beyond its free position

    def roundoff(self) -> dict[str, Scalar]:
        lengths = dict.fromkeys((self.stroke, self.extension), ROUNDED_LENGTH)
        return {f"{self.name}_force": ROUNDED_LENGTH * self.stiffness_at_rest, **lengths}

    def recorded(self, at: BufferState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.name}_force": self.force.tension(at.kin)}  # with its sign: negative where it is pushed in

    def springs(self, at: BufferState, closed: Closed) -> tuple[SpringDirection, ...]:
        return self.force.springs(at.kin)

    def stiff_force(self, at: BufferState, closed: Closed) -> Scalar:
        return jnp.abs(self.force.tension(at.kin))

    @property
    def reversing(self) -> int:
        return int(self.rubs)

    def reversals(self, at: BufferState, closed: Closed) -> Float[Array, "reversing axes"]:
        if not isinstance(self.force, BufferForce) or self.force.friction is None:
            return super().reversals(at, closed)
        others = jnp.zeros(at.kin.basis.dimensions - 1)
        return jnp.append(at.stroke_rate / self.force.friction_speed, others)[None]

    @property
    def tolerance_share(self) -> float:
        """Return less than one with measured curves: between two of their pieces the second derivative jumps."""
        force = self.force
        measured = isinstance(force, BufferForce) and not (force.spring_curve is None and force.damper_curve is None)
        return PIECES if measured else 1.0

    @property
    def report(self) -> "BufferReport":
        return BufferReport(self)


class BufferReport(Report[Buffer]):
    """What is said and drawn of a buffer."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        buffer = self.element
        force = SummaryRow.largest(run, f"{buffer.name}_force", "N", f"peak {self.words} force")
        stroke = SummaryRow.largest(
            run, buffer.stroke, "m", buffer.stroke.replace("_", " "), limit=buffer.longest_stroke
        )
        return [force.line, stroke.line, *extension_line(run, buffer.extension)]

    @property
    def summary_observables(self) -> tuple[str, ...]:
        return f"{self.element.name}_force", self.element.stroke

    def panels(self, run: Any) -> list[Panel]:
        buffer = self.element
        most = largest(run, buffer.stroke)
        curve = PanelCurve("", 1e3 * run.history.others[buffer.stroke])
        title = buffer.stroke.replace("_", " ").capitalize()
        levels = Level(f"largest, {1e3 * most:.4g} mm", 1e3 * most), Level("", 0.0)
        return [Panel(title, "stroke [mm]", (curve,), levels)]

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        buffer = self.element
        friction = f"{self.words}'s friction"
        return (EnergyShare(friction, f"lost in the {friction}", (buffer.rubbed_in,)),) if buffer.rubs else ()


def extension_line(run: Any, name: str = "extension") -> list[tuple[str, str]]:
    """Return the line on how far a buffer's rod goes out beyond its free position, and when; none where it never
    does."""
    row = SummaryRow.largest(run, name, "m", name.replace("_", " "), note=" beyond the free length")
    return [row.line] if row.value > LEAST_SHOWN else []


LEAST_SHOWN = 1e-9  # m; a shorter extension is rounding
PIECES = 0.2  # see `Buffer.tolerance_share`
