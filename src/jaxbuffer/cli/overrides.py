"""Design and scenario fields as command line options: ``--buffer.k_A 800`` or ``--buffer.k_A=800``."""

from collections.abc import Collection, Sequence
from typing import Any

from typer import Context
from typer.core import TyperCommand

from ..errors import InputError, nearest
from . import completion

FIELDS = """\
\b
Fields (each as --section.field VALUE here, or under [section] in CONFIG.toml;
those of the capture mechanism, 'jaxbuffer fields KIND' has any mechanism's):
  active    mass [kg], inertia [kg m²], hinge_offset [m]
  passive   mass [kg], inertia [kg m²]
  buffer    k_A [N/m], c_A [N s/m], k_T [N m/rad], c_T [N m s/rad],
            free_length [m], cylinder_mass [kg], cylinder_length [m],
            max_stroke [m] (default: free_length), stop_stiffness [N/m]
            (default: no end stop), stop_damping [N s/m],
            stop_thickness [m] (of rubber; default: it is linear),
            spring_curve (points [stroke, force] in place of k_A),
            damper_curve (points [speed, force] in place of c_A, c_A2):
            "[[0.005, 2.0], [0.01, 6.0]]" say; one of their numbers is
            --buffer.spring_curve.force[1] VALUE;
            preload [N], preload_length [m], c_A2 [N s²/m²],
            rebound_factor [-], friction [N], friction_speed [m/s],
            rebound_stiffness [N/m] (default: the spring also pulls),
            rebound_damping [N s/m], rebound_gap [m],
            damping (physical, published)
  probe     length [m], rod_mass [kg], tip_radius [m], tip_mass [kg],
            free_tip (true, false), bending_stiffness [N m²] (default: rigid),
            bending_modes (2, 3, …), bending_damping [s]
  hinge     play [m] (default: none), bush_radius [m], damping [s/m],
            young_modulus [Pa], poisson_ratio [-]
  latch     stiffness [N/m] (default: no latch), damping [N s/m],
            preload [N], preload_length [m], turn_stiffness [N m/rad],
            turn_damping [N m s/rad], closing_time [s], depth [m],
            strength [N] (default: none tears it), quiet [-]
  shock     active_1 [Hz], active_2 [Hz], active_3 [Hz], passive_1 [Hz],
            passive_2 [Hz], passive_3 [Hz] (default: none), damping [-]
  cone      half_angle [rad], offset [m], throat_radius [m], length [m],
            young_modulus [Pa], poisson_ratio [-] (default: contact's)
  contact   law (lankarani-nikravesh, hertz, exact, kelvin-voigt, adams, …),
            stiffness [N/m^1.5], restitution [-], friction [-],
            slip_speed [m/s], young_modulus [Pa], poisson_ratio [-],
            yield_stress [Pa] (default: not checked),
            linear_stiffness [N/m], damping [N s/m], exponent [-],
            ramp_depth [m], onset_length [m], memory_time [s],
            memory (event, smooth), arms (moving, published)
  scenario  approach_speed [m/s], contact_distance [m],
            misalignment [rad], passive_rate [rad/s], start (contact, free);
            of a free start: offset [m], standoff [m], active_angle [rad],
            active_rate [rad/s], lateral_speed [m/s]; of any: thrust [N] with
            thrust_time [s]
"""

WITH_QUANTITIES = (
    """\
\b
Quantities (each as --of QUANTITY; whole run, then the first impact's closed form, then any impact;
those of the capture mechanism, 'jaxbuffer fields KIND' has any mechanism's):
  peak_force [N], peak_vehicle_force [N], peak_hinge_force [N], stroke [m], hinge_angle [rad], bending [m],
  extension [m]        how far the buffer's rod goes out beyond its free position
  end_time [s], peak_time [s], peak_buffer_force [N], contact_time [s],
  stroke_time [s], extension_time [s], hinge_angle_time [s], peak_hinge_force_time [s],
  peak_buffer_force_time [s], peak_latch_force_time [s]  without derivatives
  relative_energy [-]  energy of relative motion at the end over that at the start; in joules:
  energy_left [J]; over that of both vehicles at 0.1 m/s: reference_energy_left [-]
  latch_energy [J], latch_energy_share [-]  put in by the closing of the latches, and over that at the start
  arrest_stroke [m]    stroke at which the axial spring would store it
  peak_latch_force [N], latch_share [-] of its strength, latch_time [s], settling_time [s] from there until held
  lateral_miss [m], attitude_miss [rad], lateral_miss_rate [m/s], attitude_miss_rate [rad/s]  at the capture plane
  active_shock_1 [m/s²], active_shock_2 [m/s²], active_shock_3 [m/s²], passive_shock_1 [m/s²],
  passive_shock_2 [m/s²], passive_shock_3 [m/s²]  of equipment of the frequencies shock.active_1 and so on
  peak_active_acceleration [m/s²], peak_passive_acceleration [m/s²], impulse [N s]
  throat_distance [m]  of the tip before the capture plane at the end; at any time, with --duration
  capture_margin [m]   of the tip beyond that plane at the duration, coasting on from the end; or, if less,
  stroke_margin [m]    stroke left before the buffer's end
  capture_share [-]    of the tip beyond that plane at the duration, over its distance from it at the start
  stroke_share [-]     share of the buffer's stroke that is used, above 1 where the run bottoms
  peak_stop_force [N], penetration [m], contact_pressure [Pa]
  axial_loss [J], torsional_loss [J], contact_loss [J], friction_loss [J], stop_loss [J],
  bending_loss [J], play_loss [J], buffer_friction_loss [J], rebound_loss [J], latch_loss [J], dissipated [J]
  effective_mass [kg], effective_energy [J], elastic_first_peak [N], predicted_first_peak [N]
  impact.N.peak_force [N], impact.N.approach_speed [m/s], impact.N.time [s], impact.N.release_time [s],
  impact.N.effective_energy [J], impact.N.compression_end [s]

"""
    + FIELDS
)


class Plain(TyperCommand):
    """A command that takes each option once, unless it is repeatable, and no empty words."""

    def parse_args(self, ctx: Context, args: list[str]) -> list[str]:
        """Check the words, then parse them."""
        if not ctx.resilient_parsing:  # of a shell's completion, in which words are still missing
            check_words(args, [name for it in self.params if getattr(it, "multiple", False) for name in it.opts])
        return super().parse_args(ctx, args)


class Command(Plain):
    """A command that sets dotted options aside, as text, in the context's ``obj``.

    They are taken out before the parser sees them: to it their values would look like the CONFIG argument.
    """

    def parse_args(self, ctx: Context, args: list[str]) -> list[str]:
        """Parse what is left without the dotted options."""
        ctx.meta[completion.WORDS] = args
        rest, ctx.obj = split(args, unfinished=ctx.resilient_parsing)
        if ctx.resilient_parsing and completion.joined():
            rest = [*rest, "CONFIG"]  # else the unfinished value would be completed as if it were CONFIG
        try:
            return super().parse_args(ctx, rest)
        except Exception as error:
            option = getattr(error, "option_name", "")
            # By name, since some versions of typer have a copy of click's classes and others import click itself.
            unknown = type(error).__name__ == "NoSuchOption" and not getattr(error, "possibilities", None)
            if not unknown or not (alike := fields_like(option)):
                raise
            raise InputError(f"No such option: {option}; did you mean {' or '.join(alike)}?") from None

    def shell_complete(self, ctx: Context, incomplete: str) -> list[Any]:
        """Offer dotted options beside the others, and what is the value of one."""
        words = ctx.meta.get(completion.WORDS, ())
        own = completion.field_options(words, incomplete) or completion.value(words, incomplete)
        return [*super().shell_complete(ctx, incomplete), *own]


def fields_like(option: str) -> list[str]:
    """Return the dotted options that one without a section may mean: of the fields whose last part it is or is in, or
    of the field nearest to it; a capture's first."""
    # here, because both import JAX, for which neither help nor other refusals of options wait
    from ..fields import addresses
    from ..mechanisms import all_mechanisms

    name = option.lstrip("-").replace("-", "_")
    every = [addresses(mechanism.design(), mechanism.scenario()) for mechanism in all_mechanisms()]
    exact = ([path for path in known if path.rpartition(".")[2] == name] for known in every)
    # One or two letters are part of many fields' names.
    partly = ([path for path in known if name in path.rpartition(".")[2]] for known in every if len(name) > 2)
    near = ([path] for known in every if (path := nearest(name, known)))
    # The closest kind of likeness counts, within it the first mechanism: a capture's.
    matches = next((paths for group in (exact, partly, near) for paths in group if paths), [])
    return [f"--{path}" for path in matches]


def check_words(words: Sequence[str], repeatable: Collection[str]) -> None:
    """Raise `InputError` for an option given twice that is not ``repeatable``, and for an empty word."""
    options = [word.partition("=")[0] for word in words if word.startswith("--")]
    for name in options:
        if name not in repeatable and options.count(name) > 1:
            raise InputError(f"{name} is given twice; keep one")
    # An empty word, such as a shell variable that is not set, is named after the option before it.
    for before, word in zip(["an argument", *words], words, strict=False):
        if not word or (word.startswith("--") and word.endswith("=")):
            name = word.rstrip("=") or (before if before.startswith("--") else "an argument")
            raise InputError(f"{name} is empty; give it a value or leave it out")


def split(arguments: Sequence[str], unfinished: bool = False) -> tuple[list[str], dict[str, str]]:
    """Split ordinary arguments from the dotted options with their values; ``unfinished``: whether a shell completes
    them, so that nothing is an error yet."""
    rest, overrides = list[str](), dict[str, str]()
    words = iter(arguments)
    for word in words:
        name, equals, value = word.partition("=")
        # After this word there are no more options, by convention.
        if word == "--":
            rest += [word, *words]
        elif name.startswith("--") and "." in name:
            path = name.removeprefix("--")
            # A field at the very end lacks its value like one before an option, and is refused in the same words.
            given = value if equals else next(words, "--")
            if unfinished:
                continue
            if given.startswith("--"):
                raise InputError(f"{path} needs a value: --{path} VALUE")
            if path in overrides:
                raise InputError(f"--{path} is given twice, as {overrides[path]} and as {given}; keep one")
            overrides[path] = given
        else:
            rest.append(word)
    return rest, overrides
