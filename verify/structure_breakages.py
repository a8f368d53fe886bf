"""Finite elements, their contact, liquid, composites and shock broken on purpose, and which checks ought to notice."""

from .breakage import Breakage

STRUCTURES = "tests/structures"
CONTACT = f"{STRUCTURES}/test_plane_contact.py"
SERVED = f"{CONTACT}::test_a_defence_node_is_a_multiplier_where_no_two_pairs_share_a_node"
MOMENT = f"{CONTACT}::test_the_published_distribution_turns_bodies_of_unequal_masses"
PARTED = f"{STRUCTURES}/test_two_bars.py::test_two_free_bars_exchange_their_speeds"
SAFE = f"{STRUCTURES}/test_two_bars.py::test_the_step_found_is_safe_with_a_penalty"
BOUNCING = f"{STRUCTURES}/test_bouncing_bar.py::test_nodes_move_exactly_at_a_courant_number_of_one[20-multiplier]"
ENERGIES = f"{STRUCTURES}/test_bouncing_bar.py::test_energy_is_kept_to_rounding"
BENT = f"{STRUCTURES}/test_quads.py::test_one_element_across_bends_as_the_closed_form_says"
RANK = f"{STRUCTURES}/test_quads.py::test_elements_turn_rigidly_without_stress_and_resist_every_hourglass"
LOGARITHM = f"{STRUCTURES}/test_strain.py::test_it_is_half_the_logarithm_of_c"
SHEARED = f"{STRUCTURES}/test_plastic.py::test_pure_shear_loads_unloads_and_loads_back_as_hand_calculation_says"
CUSHION = f"{STRUCTURES}/test_layer.py::test_with_a_damper_it_presses_until_its_force_is_zero_and_never_pulls"
FRAME = "test_it_sags_under_its_own_weight_as_a_frame_of_beams[perforated-0.004-0.03]"
PLATES = f"tests/mechanisms/test_tank_plates.py::{FRAME}"
RIBBED = "tests/mechanisms/test_tank_ribs.py::test_it_sags_under_its_own_weight_as_a_frame_of_ribbed_beams"
SIDEWAYS = "tests/mechanisms/test_drop_angle.py::test_the_tank_takes_the_tangent_of_the_angle_sideways"
SUNK = "tests/mechanisms/test_tank_drop.py::test_a_rigid_tank_sinks_by_its_weight_over_the_supports_stiffness[2]"
PISTON = f"{STRUCTURES}/test_acoustics.py::test_a_piston_on_a_column_swings_at_its_first_frequency_and_keeps_its_energy"
JOUKOWSKY = f"{STRUCTURES}/test_acoustics.py::test_a_heavy_piston_sends_joukowskys_pressure_up_a_long_column"
FILLED = f"{STRUCTURES}/test_filled.py"
BULK = f"{FILLED}::test_a_closed_column_is_as_stiff_as_its_bulk"
PERFORATED = f"{STRUCTURES}/test_perforated.py"
HELD = f"{PERFORATED}::test_the_flow_through_a_plate_that_is_held[300000000.0]"
GOES_ALONG = f"{PERFORATED}::test_a_plate_that_is_free_goes_along[0.2-400.0]"
LID = f"{FILLED}::test_a_lid_on_a_surface_meets_joukowskys_pressure"
AIR = f"{FILLED}::test_trapped_air_is_a_gas_spring"
PLY = "tests/composites/test_failure.py::test_a_sixty_degree_ply_of_graphite"
UNIAXIAL = "tests/composites/test_failure.py::test_each_uniaxial_strength_has_a_reserve_factor_of_one"
FLOWED = f"{STRUCTURES}/test_plastic_bending.py::test_moments_are_those_of_fibres[0.4-0.0]"
FIBRES = "tests/composites/test_laminate.py::test_a_turned_ply_pulled_along_its_fibres_carries_along_them_only"
MOTION = "tests/shock/test_pulses.py::test_responses_solve_the_equation_of_motion"
LARGEST = "tests/shock/test_pulses.py::test_largest_responses_over_the_duration"
SPECTRUM = "tests/shock/test_spectrum.py::test_a_damped_spectrum_of_a_half_sine"


def _heavy_foot() -> None:
    import jax.numpy as jnp

    from jaxbuffer.structures.contact import forces

    def broken(slaves, pairs, weights, inverse_mass):
        own = forces._along(inverse_mass[slaves], pairs.normal)
        nodes = forces._along(inverse_mass[pairs.nodes], pairs.normal[:, None])
        return own + 1.0 / jnp.sum(pairs.weights / jnp.where(nodes > 0.0, nodes, jnp.inf), axis=1)

    forces._yielding = broken


def _always_published() -> None:
    from jaxbuffer.structures.contact import NodeContact, forces

    distribution = forces._distribution

    def broken(contact, *rest):
        return distribution(NodeContact(contact.slaves, contact.surface, contact.method, published=True), *rest)

    forces._distribution = broken


def _sticking() -> None:
    import jax.numpy as jnp

    from jaxbuffer.structures.contact import forces

    forces._closing_forces = lambda matrix, yielding, speed, active: jnp.where(active, speed, 0.0) / yielding


def _penalty_forgotten() -> None:
    import jax.numpy as jnp

    from jaxbuffer.structures import FiniteElementSystem

    FiniteElementSystem._penalties = lambda self, contact: jnp.zeros(())


def _plates_hang() -> None:
    from jaxbuffer.mechanisms.tank_drop.numbering import Numbering

    whole = Numbering.of

    def broken(design):
        numbers = whole(design)
        joined = len(numbers.corners) - design.mesh.refinement * (len(numbers.plate) > 0)
        return numbers._replace(corners=numbers.corners[:joined])

    Numbering.of = staticmethod(broken)


def _wide_ribs() -> None:
    from jaxbuffer.mechanisms.tank_drop import assembly

    deepened = assembly._with_ribs

    def broken(design, quads):
        thin, density = deepened(design, quads)
        rib = thin.weight < quads.weight
        return thin._replace(weight=thin.weight * (1.0 + 0.16 * rib)), density / (1.0 + 0.16 * rib[:, 0])

    assembly._with_ribs = broken


def _upright_push() -> None:
    import jax.numpy as jnp

    from jaxbuffer.structures.contact import RigidPlane

    on_nodes = RigidPlane.on_nodes

    def broken(self, slaves, force, nodes):
        return on_nodes(self, slaves, force * jnp.array([[0.0, 1.0]]), nodes)

    RigidPlane.on_nodes = broken


def _support_by_node() -> None:
    import equinox as eqx
    import jax.numpy as jnp

    from jaxbuffer.mechanisms.tank_drop import assembly

    pressed = assembly._pressed

    def broken(design, mesh, slaves, plane):
        contact = pressed(design, mesh, slaves, plane)
        evenly = jnp.full_like(contact.stiffness, 0.02 * design.support.stiffness)  # strips of the coarsest mesh
        return eqx.tree_at(lambda c: c.stiffness, contact, evenly)

    assembly._pressed = broken


def _late_energy() -> None:
    import jax.numpy as jnp

    from jaxbuffer.structures import central_differences

    advance = central_differences.advance

    def broken(system, state, step, near):
        after, instant = advance(system, state, step, near)
        kinetic = 0.5 * jnp.sum(system.mass * after.velocity**2)
        return after, instant._replace(energies=instant.energies._replace(kinetic=kinetic))

    central_differences.advance = broken


def _no_narrowing() -> None:
    from jaxbuffer.structures import Quads

    strains = Quads.strains
    Quads.strains = lambda self, displacements, coupling: strains(self, displacements, 0.0 * coupling)


def _hourglasses() -> None:
    from jaxbuffer.structures import Quads

    strains = Quads.strains
    Quads.strains = lambda self, *rest: strains(self._replace(hourglass=0.0 * self.hourglass), *rest)


def _short_series() -> None:
    from jaxbuffer.structures import strain

    quotient = strain._artanh_over_argument
    strain._artanh_over_argument = lambda squared: quotient(squared) - squared**2 * (squared < strain.SMALL) / 5.0


def _hardening() -> None:
    from jaxbuffer.structures import Plastic

    answer = Plastic.answer

    def broken(self, strain, history):
        softer = Plastic(
            self.density, self.young, self.poisson, self.yield_stress, 0.99 * self.hardening, self.failure_strain
        )
        return answer(softer, strain, history)

    Plastic.answer = broken


def _elastic_narrowing() -> None:
    from jaxbuffer.structures import Plastic

    flowed = Plastic.flowed_across
    Plastic.flowed_across = lambda self, history: 0.9 * flowed(self, history)


def _damper_sign() -> None:
    from jaxbuffer.structures.contact import Layer

    forces = Layer.forces
    Layer.forces = lambda self, positions, velocity: forces(self, positions, -velocity)


def _sucking_liquid() -> None:
    from jaxbuffer.structures import Liquid

    push = Liquid.push
    Liquid.push = lambda self, *arguments: -push(self, *arguments)


def _weightless_liquid() -> None:
    from jaxbuffer.structures import Liquid

    struck = Liquid.struck
    Liquid.struck = lambda self, *moves: struck(self, *moves) / self.density


def _half_swept() -> None:
    from jaxbuffer.structures import Liquid

    rate = Liquid.rate
    Liquid.rate = lambda self, impulse, velocity, *others: rate(self, impulse, 0.99 * velocity, *others)


def _plate_unmoved() -> None:
    from jaxbuffer.structures.perforated import Perforated

    push = Perforated.push
    Perforated.push = lambda self, *arguments: 0.0 * push(self, *arguments)


def _smooth_holes() -> None:
    from jaxbuffer.structures.perforated import Perforated

    resistance = Perforated.resistance
    Perforated.resistance = lambda self, *arguments: 0.5 * resistance(self, *arguments)


def _sticky_surface() -> None:
    import jax.numpy as jnp

    from jaxbuffer.structures.acoustics import Cover

    def broken(self, displacement, raised):
        moved = jnp.sum(self.shares * displacement[self.wall, 1], axis=1)
        return raised - self.width * (self.gap + moved)

    Cover.overlap = broken


def _isothermal() -> None:
    from jaxbuffer.structures import gas

    gas.Gas.overpressure = lambda self, positions: self.pressure * (1.0 / self.share(positions) - 1.0)


def _tension_only() -> None:
    from jaxbuffer.composites import failure

    failure._by_sign = lambda stress, strength: (
        0.0 * stress[..., 0] + strength.along_tension,
        0.0 * stress[..., 1] + strength.across_tension,
    )


def _turned_back() -> None:
    from jaxbuffer.composites import ply

    turn = ply.in_ply_axes
    ply.in_ply_axes = lambda angle: turn(-angle)


def _pulse_goes_on() -> None:
    from jaxbuffer.shock import pulses

    first, second = pulses.PULSES["half-sine"]
    pulses.PULSES = {**pulses.PULSES, "half-sine": (first, second._replace(factor=-second.factor))}


def _still_at_the_end() -> None:
    from jaxbuffer.shock import pulses

    pulses._rate_at_the_end = lambda pulse, ratio: 0.0 * ratio


def _filter_undamped() -> None:
    from jaxbuffer.shock import spectrum

    weights = spectrum._filter

    def broken(frequencies, step, damping):
        *others, twice = weights(frequencies, step, damping)
        return (*others, twice**0.999)

    spectrum._filter = broken


STRUCTURE = (
    Breakage("heavy foot", "a defence node of the mass Σφ m for 1/Σ(φ²/m)", _heavy_foot, (SERVED,)),
    Breakage("foot's forces", "forces by Zhong's distribution where none was asked for", _always_published, (MOMENT,)),
    Breakage("sticking", "contact in explicit dynamics pulls", _sticking, (PARTED, BOUNCING)),
    Breakage("bent flow", "what has flowed narrows a bent wall by a tenth too little", _elastic_narrowing, (FLOWED,)),
    Breakage("penalty's step", "a penalty left out of the critical step", _penalty_forgotten, (SAFE,)),
    Breakage("plates hang", "baffle plates that are joined to the bottom alone", _plates_hang, (PLATES,)),
    Breakage("wide ribs", "ribs that are held along the tank, 16 % too stiff", _wide_ribs, (RIBBED,)),
    Breakage("upright push", "a slider at an angle that pushes straight down only", _upright_push, (SIDEWAYS,)),
    Breakage("support by node", "a support that is stiffer on a finer mesh", _support_by_node, (SUNK,)),
    Breakage("late energy", "kinetic energy half a step late", _late_energy, (ENERGIES,)),
    Breakage("no narrowing", "elements that bend are not narrowed: they lock", _no_narrowing, (BENT,)),
    Breakage("hourglasses", "hourglass shapes are not strained", _hourglasses, (RANK, BENT)),
    Breakage("short series", "the third term of the logarithmic strain's series lost", _short_series, (LOGARITHM,)),
    Breakage("hardening", "the yield stress rises by 1 % less", _hardening, (SHEARED,)),
    Breakage("cushion's damper", "the cushion's damper drives", _damper_sign, (CUSHION,)),
    Breakage("sucking liquid", "the liquid pulls at the wall where it should push", _sucking_liquid, (PISTON,)),
    Breakage(
        "weightless liquid",
        "the density lost in the coupling of wall and liquid, as in the tank paper's eq. 4",
        _weightless_liquid,
        (PISTON, JOUKOWSKY),
    ),
    Breakage("plate unmoved", "a plate with holes that no pressure moves", _plate_unmoved, (GOES_ALONG,)),
    Breakage("smooth holes", "holes that lose half of the pressure they should", _smooth_holes, (HELD,)),
    Breakage("half swept", "a full tank's liquid feels 1 % less of its wall's motion", _half_swept, (BULK,)),
    Breakage("sticky surface", "a surface that pulls at the wall above it", _sticky_surface, (LID,)),
    Breakage("isothermal air", "trapped air that gives its heat away at once", _isothermal, (AIR,)),
    Breakage("tension only", "strengths of tension for compression too", _tension_only, (PLY, UNIAXIAL)),
    Breakage("turned back", "a ply's stiffness turned the other way", _turned_back, (FIBRES,)),
    Breakage("endless pulse", "the half-sine's second half does not end it", _pulse_goes_on, (MOTION,)),
    Breakage("still at the end", "a pulse leaves the oscillator without a speed", _still_at_the_end, (LARGEST,)),
    Breakage(
        "spectrum's filter",
        "Smallwood's filter damps by 0.1 % less in one of its weights",
        _filter_undamped,
        (SPECTRUM,),
    ),
)
