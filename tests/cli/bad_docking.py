"""Latches, free starts, real buffers and measured curves, given badly."""

from bad_inputs import call, line, toml

from jaxbuffer import Diffrax, Scenario, as_diffrax, get, replace, sensitivity, simulate, table2

LATCHED = replace(table2(), {"latch.stiffness": 2e5})  # N/m
PUSHED = Scenario(thrust=1.0, thrust_time=1.5)  # N, s
MEASURED = "[buffer]\nspring_curve = [[0.005, 2], [0.01, 6]]\n"
SPRING = "buffer.spring_curve"
NO_CURVE = f"{SPRING} = [[0.01]] is not a curve; write a list of points [stroke [m], force [N]]"
TOGETHER = f"{SPRING} and buffer.k_A are given together; the curve stands for k_A: keep one of them"


def points(text):
    return f"[buffer]\nspring_curve = {text}"


DOCKING = [
    # starts
    toml(
        "[scenario]\noffset = 0.01", 'scenario.offset = 0.01 m belongs to scenario.start = "free"; here it is "contact"'
    ),
    toml("[scenario]\nstandoff = '1 cm'", 'scenario.standoff = 0.01 m belongs to scenario.start = "free"'),
    toml("[scenario]\nactive_angle = '3 deg'", "scenario.active_angle = 0.0523599 rad belongs to"),
    toml("[scenario]\nactive_rate = 0.1", "scenario.active_rate = 0.1 rad/s belongs to"),
    toml("[scenario]\nlateral_speed = 0.1", "scenario.lateral_speed = 0.1 m/s belongs to"),
    toml(
        "[scenario]\nstart = 'free'\ncontact_distance = 0.03",
        'scenario.contact_distance = 0.03 m belongs to scenario.start = "contact"; here it is "free"',
    ),
    line("simulate --scenario.offset 5mm", 'scenario.offset = 0.005 m belongs to scenario.start = "free"'),
    line("sweep --over scenario.offset=-0.01:0.01:3", 'scenario.offset = -0.01 m belongs to scenario.start = "free"'),
    toml("[problem.grid]\noffset = [-0.01, 0.01]", 'scenario.offset = -0.01 m belongs to scenario.start = "free"'),
    toml("[sample.ranges]\nscenario.offset = [-0.01, 0.01]", 'offset = -0.01 m belongs to scenario.start = "free"'),
    toml("[scenario]\nthrust = 1", "scenario.thrust needs scenario.thrust_time [s] too"),
    toml("[scenario]\nthrust_time = 1", "scenario.thrust_time needs scenario.thrust [N] too"),
    toml("[scenario]\nstrat = 'free'", "scenario.strat is unknown; did you mean scenario.start?"),
    # measured curves
    toml(points("[]"), f"{SPRING} = [] is not a curve; write a list of points [stroke [m], force [N]], rising in both"),
    toml(points("[0.01, 2]"), f"{SPRING} = [0.01, 2] is not a curve"),
    toml(points("[[0.01]]"), NO_CURVE),
    toml(points("[[0.01, 2, 3]]"), f"{SPRING} = [[0.01, 2, 3]] is not a curve"),
    toml(points("3"), f"{SPRING} = 3 is not a curve"),
    toml(
        points("[[0.01, 2], [0.02, 1]]"), f"{SPRING}.force[1] = 1 N must be above force[0] = 2 N: a curve's points rise"
    ),
    toml(points("[[0.01, 2], [0.01, 3]]"), f"{SPRING}.stroke[1] = 0.01 m must be above stroke[0] = 0.01 m"),
    toml(points("[[0, 0], [0.01, 3]]"), f"{SPRING}.stroke[0] = 0 m must be above 0", "(0, 0) is understood"),
    toml(points("[[0.01, -3]]"), f"{SPRING}.force[0] = -3 N must be above 0"),
    toml(points("[[0.01, nan]]"), f"{SPRING}.force[0] = nan N must be above 0"),
    toml(points("[[0.01, true]]"), f"{SPRING}.force[0]: True is not a number in N"),
    toml(points("[['1 cm', '2 kg']]"), f"{SPRING}.force[0] = '2 kg': kg is a mass, expected a number in N"),
    toml(points("[['1 cN', '2 N']]"), f"{SPRING}.stroke[0] = '1 cN': cN is a force, expected a number in m"),
    toml(
        "[buffer]\ndamper_curve = [[1, 2], ['2 rpm', 5]]", "damper_curve.speed[1] = '2 rpm'", "expected a number in m/s"
    ),
    toml(MEASURED + "k_A = 800", TOGETHER),
    toml(
        "[buffer]\ndamper_curve = [[0.1, 2]]\nc_A = 5",
        "buffer.damper_curve and buffer.c_A are given together; the curve stands for c_A and c_A2: keep one of them",
    ),
    toml("[buffer]\ndamper_curve = [[0.1, 2]]\nc_A2 = 5", "buffer.damper_curve and buffer.c_A2 are given together"),
    line("simulate study.toml --buffer.k_A 800", TOGETHER, study=MEASURED),
    line("sweep study.toml --over buffer.k_A=400,800", TOGETHER, study=MEASURED),
    line(["simulate", f"--{SPRING}", "[[0.01]]"], NO_CURVE),
    line(["simulate", f"--{SPRING}", "[[0.01"], f"{SPRING} = '[[0.01' is not a curve"),
    line(
        f"simulate --{SPRING}.force[0] 2", f"{SPRING}.force[0] is unknown: {SPRING} is not set; give its points first"
    ),
    line(
        f"simulate study.toml --{SPRING}.force[2] 9",
        f"{SPRING}.force[2] is unknown",
        "stroke[0] to force[1]",
        study=MEASURED,
    ),
    line(f"simulate study.toml --{SPRING}.force[1] 1", f"{SPRING}.force[1] = 1 N must be above", study=MEASURED),
    line(f"sweep study.toml --over {SPRING}.force[1]=1,9", f"{SPRING}.force[1] = 1 N must be above", study=MEASURED),
    line(f"sweep study.toml --over {SPRING}=1,9", f"{SPRING} is a measured curve, whose numbers are", study=MEASURED),
    line(
        f"sensitivity study.toml --wrt {SPRING}",
        f"{SPRING} = [[0.005, 2.0], [0.01, 6.0]] is not a number",
        study=MEASURED,
    ),
    line("sensitivity study.toml --wrt buffer.k_A", "buffer.k_A = None is not a number", study=MEASURED),
    toml(f"[sample.ranges]\n{SPRING} = [1, 2]\n{MEASURED}", f"{SPRING} is a measured curve, whose numbers are"),
    toml(
        f"[problem.variables]\n{SPRING} = [1, 2]\n{MEASURED}",
        f"{SPRING} is a measured curve",
        "only numbers can be tuned",
    ),
    line(
        "tune study.toml",
        "buffer.k_A = None is not a number that can be tuned",
        study=MEASURED + "[problem.variables]\nbuffer.k_A = [100, 2000]",
    ),
    call(lambda: get(table2(), f"{SPRING}.force[0]"), f"{SPRING}.force[0] is unknown: {SPRING} is not set"),
    call(
        lambda: replace(table2(), {SPRING: [[0.01, 2.0]], "buffer.k_A": 500.0}),
        TOGETHER,
    ),
    # the rest of a real buffer
    toml(
        "[buffer]\nrebound_damping = 5", "rebound_damping = 5 N s/m needs a rebound stop: give buffer.rebound_stiffness"
    ),
    *[
        toml(f"[buffer]\ndamping = 'published'\n{more}", 'buffer.damping = "published" has the paper\'s damper alone')
        for more in ("rebound_factor = 2", "c_A2 = 10", "damper_curve = [[0.1, 2]]")
    ],
    # latches
    toml(
        "[latch]\nstiffness = 2e5\npreload = 20\nstrength = 15",
        "latch.strength = 15 N must be above latch.preload = 20 N: the preload alone would tear the latch",
    ),
    toml("[latch]\nstiffness = 2e5\nclosing_time = 0\nstrength = 15", "latch.closing_time = 0 s with a latch.strength"),
    toml("[latch]\nstifness = 2e5", "latch.stifness is unknown; did you mean latch.stiffness?"),
    line("simulate --latch.stifness 2e5", "latch.stifness is unknown; did you mean latch.stiffness?"),
    toml("[lockout]\nstifness = 2e5", "lockout.stifness is unknown; did you mean lockout.stiffness?"),
    toml("[latches]\nstiffness = 2e5", "[latches] is unknown; did you mean latch?"),
    *[
        line(
            "tune study.toml",
            f"constraints.{name} needs {part}, which the design has not",
            study=f"[problem.constraints]\n{name} = 0.9",
        )
        for name, part in (
            ("peak_latch_force", "latch.stiffness"),
            ("latch_share", "latch.strength"),
            ("peak_lockout_force", "lockout.stiffness"),
            ("active_shock_1", "shock.active_1"),
        )
    ],
    line(
        "tune study.toml",
        "objective.peak_latch_force needs latch.stiffness, which the design has not",
        study="[problem.objective]\npeak_latch_force = 1",
    ),
    # what needs events
    call(
        lambda: simulate(LATCHED, solver="diffrax:Tsit5"), "latch.stiffness is given, which diffrax.diffeqsolve cannot"
    ),
    call(lambda: simulate(table2(), PUSHED, solver=Diffrax()), "scenario.thrust is given, which diffrax.diffeqsolve"),
    call(lambda: as_diffrax(LATCHED), "latch.stiffness is given", "it locates no events on the way"),
    call(lambda: sensitivity(LATCHED, solver="diffrax:Tsit5"), "latch.stiffness is given, which diffrax.diffeqsolve"),
]
