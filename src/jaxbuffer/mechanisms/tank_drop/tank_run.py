"""A drop onto a tank: its numbers beside what every run has."""

from jaxtyping import Array, Float, Int

from ..run import Run


class TankRun(Run):
    """A drop onto a tank. Print it for a summary. Forces, masses and energies are those of the whole tank.

    Besides what every `Run` has:

    - ``impulse``: of the contact force on the slider [N s].
    - ``momentum``: by which the slider was slowed down, its weight's share included [N s].
    - ``peak_stress``: largest stress after von Mises on the wall's faces [Pa], at element ``stress_element``.
    - ``smooth_stress``: a smooth maximum of the stress over wall and time, below the largest by ``smooth_bias`` at most
      [Pa].
    - ``plastic_strain``: largest equivalent plastic strain at the end [-]; ``plastic_work`` [J]; ``deleted``: elements.
    - ``deflection``: largest, of the middle of the top downwards [m]; ``travel`` of the slider [m].
    - ``compression``: largest, of the cushion over its thickness [-].
    - ``highest_pressure``, ``lowest_pressure``: of the liquid on the wall, with the static one [Pa].
    - ``yield_time``, ``solid_time``, ``torn_time``, ``crack_time``: when the wall first yields or a ply of it fails,
      the cushion is solid, the liquid is under less than no pressure, an integration point fails; NaN if never [s].
    - ``rebound_speed``: of the slider at the end, upwards [m/s].
    - ``slide``: of the tank to the right, by the middle of its bottom, at the end [m].
    - ``reserve``: the yield stress over the largest stress; of a composite the least reserve factor of its plies [-].
    - ``wall_mass``: of wall, ribs and plates [kg]; ``step``: of the time stepping [s].
    """

    impulse: Float[Array, ""]
    momentum: Float[Array, ""]
    peak_stress: Float[Array, ""]
    stress_element: Int[Array, ""]
    smooth_stress: Float[Array, ""]
    smooth_bias: Float[Array, ""]
    plastic_strain: Float[Array, ""]
    plastic_work: Float[Array, ""]
    deleted: Int[Array, ""]
    deflection: Float[Array, ""]
    travel: Float[Array, ""]
    compression: Float[Array, ""]
    highest_pressure: Float[Array, ""]
    lowest_pressure: Float[Array, ""]
    yield_time: Float[Array, ""]
    solid_time: Float[Array, ""]
    torn_time: Float[Array, ""]
    crack_time: Float[Array, ""]
    rebound_speed: Float[Array, ""]
    slide: Float[Array, ""]
    reserve: Float[Array, ""]
    wall_mass: Float[Array, ""]
    step: Float[Array, ""]
