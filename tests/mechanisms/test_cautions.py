"""What is said before anything is computed: numbers that nothing reads, and what the geometry rules out."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.commands.request import tuned_problem
from jaxbuffer.cli.entry import run as command
from jaxbuffer.fields import get, inactive, metadata, paths
from jaxbuffer.mechanisms import all_mechanisms
from jaxbuffer.mechanisms.cautions import cautions
from jaxbuffer.mechanisms.probe_cone.assembly import assemble
from jaxbuffer.mechanisms.probe_cone.mechanism import PROBE_CONE
from jaxbuffer.study.load import load

ROOT2 = np.sqrt(2.0)


def said(changes, scenario=None, **varied):
    return cautions([(jb.replace(jb.table2(), changes), scenario or jb.Scenario())], **varied)


def other_value(part, path):
    """A value of a field that is not its default."""
    value, declared = get(part, path), metadata(part, path)
    if "choices" in declared:
        return next(word for word in declared["choices"] if word != value)
    return 0.5 * value if isinstance(value, float) and value else 0.02 if "unit" in declared else 3


@pytest.mark.quick
@pytest.mark.parametrize("mechanism", all_mechanisms(), ids=lambda it: it.name)
def test_each_number_that_needs_another_is_named_with_what_it_needs(mechanism):
    design, scenario = mechanism.design(), mechanism.scenario()
    assert inactive(design, scenario) == []
    for path in paths(design):
        if not metadata(design, path).get("needs"):
            continue
        try:
            changed = jb.replace(design, {path: other_value(design, path)})
        except jb.InputError as error:  # it cannot be given at all without what it needs
            assert path.rpartition(".")[2] in str(error)
            continue
        lines = [line for line in inactive(changed, scenario) if line.startswith(f"{path} = ")]
        assert lines == [] or " has no effect: " in lines[0]
        assert len(inactive(changed, scenario)) == len(lines)


@pytest.mark.parametrize(
    ("changes", "path", "needed"),
    [
        ({"latch.strength": 60.0}, "latch.strength = 60 N", "latch.stiffness"),
        ({"latch.turn_stiffness": 50.0}, "latch.turn_stiffness", "latch.stiffness"),
        ({"latch.stiffness": 2e3, "latch.preload_length": 1e-3}, "latch.preload_length", "latch.preload"),
        ({"shock.damping": 0.1}, "shock.damping", "shock.active_1"),
        ({"buffer.rebound_gap": 1e-3}, "buffer.rebound_gap", "buffer.rebound_stiffness"),
        ({"lockout.stiffness": 1e4}, "lockout.stiffness", "latch.stiffness"),
        ({"buffer.friction": 0.0, "buffer.friction_speed": 0.01}, "buffer.friction_speed", "buffer.friction"),
        ({"hinge.bush_radius": 0.004}, "hinge.bush_radius", "hinge.play"),
        ({"probe.bending_modes": 5}, "probe.bending_modes = 5", "probe.bending_stiffness"),
        ({"contact.linear_stiffness": 1e6}, "contact.linear_stiffness", 'contact.law = "kelvin-voigt"'),
        ({"contact.memory_time": 1e-3}, "contact.memory_time", 'contact.memory = "smooth"'),
    ],
)
def test_a_number_without_effect_is_said(changes, path, needed):
    (line,) = said(changes)
    assert line.startswith(path) and needed in line.partition("has no effect")[2]


def test_nothing_is_said_of_a_number_once_what_it_needs_is_there():
    assert said({"latch.stiffness": 2e3, "latch.strength": 60.0, "latch.turn_stiffness": 50.0}) == []
    assert said({"shock.passive_2": 60.0, "shock.damping": 0.1}) == []
    assert said({"contact.law": "kelvin-voigt", "contact.linear_stiffness": 1e6}) == []
    assert said({"latch.damping": 50.0}, varied=("latch.stiffness",)) == []  # a sweep sets it
    (line,) = said({}, varied=("latch.strength",))
    assert line.startswith("latch.strength is varied and has no effect")


def test_what_replaces_a_number_is_named():
    design = jb.replace(jb.SliderCrank(), {"rod.depth": 0.02, "rod.mass": 0.3})
    assert inactive(design, jb.SliderCrankScenario()) == [
        "rod.mass = 0.3 kg has no effect: rod.depth stands in its place"
    ]
    empty = jb.replace(jb.TankDrop(), {"contents.kind": "none"})
    (line,) = inactive(empty, jb.TankDropScenario(fill=0.5))
    assert line.startswith("scenario.fill = 0.5 has no effect") and "contents.kind" in line


def test_a_ball_larger_than_the_throat_is_said_with_how_far_it_gets():
    changes = {"probe.tip_radius": 0.042, "cone.throat_radius": 0.03}
    (line,) = said(changes)
    assert "probe.tip_radius 42 mm is above cone.throat_radius 30 mm" in line
    reach = 0.042 / ROOT2 - np.sqrt(0.042**2 - 0.03**2)  # from touching the edge at 45° to resting on both edges
    assert f"{1e3 * reach:.3g} mm behind" in line
    deep = said(changes | {"latch.stiffness": 2e3, "latch.depth": 0.01})
    assert len(deep) == 2 and deep[1].startswith("latch.depth 10 mm")
    (line,) = said({"probe.tip_radius": 0.03})  # 21.2 mm to each flank's side on the axis, in a throat of 15 mm
    assert "wedges" in line and f"{1e3 * (0.03 / ROOT2 - 0.015):.3g} mm before" in line
    assert said({"probe.tip_radius": 0.014}) == said({}) == []


@pytest.mark.quick
@pytest.mark.parametrize(
    ("numbers", "miss"),
    [
        ({"offset": 0.5}, "500 mm"),
        ({"offset": -0.1}, "100 mm"),
        ({"lateral_speed": 0.2, "standoff": 0.1}, "230 mm"),  # 115 mm forward at 0.1 m/s
        ({"offset": 0.08}, ""),  # 13 mm beyond the rim, less than the ball's radius: it touches
        ({"offset": 0.06}, ""),
    ],
)
def test_an_approach_that_misses_the_cone_is_said(numbers, miss):
    lines = said({}, jb.Scenario(start="free", **numbers))
    if not miss:
        assert lines == []
        return
    assert lines[0].startswith("the approach misses the cone") and miss in lines[0] and "scenario.offset" in lines[0]


def test_the_flight_turns_about_the_active_vehicles_centre_of_mass():
    """As the assembled mechanism has it at the start, whose tip is the radius before the mouth: turning at 0.2 rad/s it
    goes sideways at 0.2 rad/s times their distance."""
    design = jb.replace(jb.table2(), {"buffer.free_length": 0.2, "buffer.cylinder_length": 0.1})
    scenario = jb.Scenario(start="free", active_rate=0.2, standoff=0.05)
    tip = -float(design.cone.offset + design.cone.length * np.cos(design.cone.half_angle)) - 0.015 - 0.05
    centre = float(assemble(design, scenario).q[0])
    x, aside = scenario.approach.flight(design, scenario, tip)
    along = np.diff(x[:2])[0] / 0.1  # s at 0.1 m/s, turned by 1e-5 rad
    assert np.diff(aside[:2])[0] / along == pytest.approx(0.2 * (tip - centre), rel=1e-3)


def test_one_of_several_scenarios_that_misses_is_numbered():
    scenarios = [jb.Scenario(start="free", offset=x) for x in (0.01, 0.3, 0.02)]
    (line,) = cautions([(jb.table2(), it) for it in scenarios])
    assert line.endswith("(scenario 2 of 3)")


def test_check_looks_at_every_scenario_of_a_grid(tmp_path, capsys):
    """½ k_t φ² = 10 kN m/rad (1°)² = 3.05 J of ½ 4 t (5 cm/s)² = 5 J, at each of both angles."""
    study = tmp_path / "study.toml"
    study.write_text(
        'active.mass = "8 t"\npassive.mass = "8 t"\nlatch.stiffness = 4000\nlatch.turn_stiffness = 20000\n'
        '[problem.grid]\napproach_speed = ["5 cm/s", "20 cm/s"]\nmisalignment = ["-1 deg", "0 deg", "1 deg"]\n'
    )
    assert command(["check", str(study)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "adds up to 3.046 J by turning the probe, at the start's angle of 1 deg, 61 % of what" in told
    assert "adds less (scenario 1 and 1 more of 6)" in told


def test_of_several_scenarios_the_worst_is_said_with_its_number():
    runs = [(jb.table2(), jb.Scenario(start="free", offset=x)) for x in (0.01, 0.3, -0.5, 0.2)]
    (line,) = cautions(runs)
    assert "500 mm off the axis" in line and line.endswith("(worst in scenario 3; so in 3 of 4)")
    (line,) = cautions([runs[0], runs[1], runs[1]])
    assert line.endswith("(scenario 2 and 1 more of 3)")


def test_check_says_them(tmp_path, capsys):
    study = tmp_path / "study.toml"
    study.write_text('[latch]\nstrength = "60 N"\n[scenario]\nstart = "free"\noffset = "50 cm"\n')
    assert command(["check", str(study)]) == 0
    told = capsys.readouterr().out
    assert "latch.strength = 60 N has no effect: it needs latch.stiffness" in told
    assert "misses the cone: the tip passes its mouth 500 mm off the axis" in told


GRID = """
[latch]
stiffness = 300
turn_stiffness = 5
[scenario]
approach_speed = "12 cm/s"
misalignment = "3 deg"
[problem.grid]
approach_speed = ["12 cm/s", "5 cm/s"]
misalignment = ["0 deg", "3 deg"]
"""


def test_check_says_them_of_every_scenario_of_a_grid(tmp_path, capsys):
    """½ · 5 N m/rad · (3°)² = 6.85 mJ is 8.2 % of what 23 and 24 kg bring at 12 cm/s, and 47 % at 5 cm/s:
    scenario 4, though [scenario] itself is scenario 2."""
    study = tmp_path / "study.toml"
    study.write_text(GRID)
    assert command(["check", str(study)]) == 0
    told = capsys.readouterr().out
    assert "adds up to 6.854 mJ by turning the probe" in told and "(scenario 4 of 4)" in told
    for numbered in ("1: 0.12 m/s, 0°", "2: 0.12 m/s, +3°", "3: 0.05 m/s, 0°", "4: 0.05 m/s, +3°"):
        assert f" {numbered}\n" in told


def test_a_tuning_says_them_of_every_scenario_of_a_grid(tmp_path, capsys):
    study = tmp_path / "study.toml"
    study.write_text(GRID)
    tuned_problem(load(study))
    assert "(scenario 4 of 4)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ({"buffer.max_stroke": 0.2}, ("buffer.max_stroke", "buffer.free_length")),
        ({"hinge.play": 0.01}, ("hinge.play", "hinge.bush_radius")),
        ({"probe.tip_radius": 0.2}, ("probe.tip_radius", "cone.throat_radius", "cone.length")),
    ],
)
def test_a_range_that_another_number_ends_names_that_number(changes, names):
    with pytest.raises(jb.InputError) as error:
        jb.replace(jb.table2(), changes)
    assert all(name in str(error.value) for name in names)


def test_a_first_contact_beyond_the_flank_names_its_length():
    with pytest.raises(jb.InputError, match=r"scenario.contact_distance.*cone.length"):
        jb.simulate(jb.table2(), jb.Scenario(contact_distance=0.2))
    with pytest.raises(jb.InputError, match=r"scenario.misalignment.*cone.half_angle"):
        jb.simulate(jb.table2(), jb.Scenario(misalignment=1.0))
    with pytest.raises(jb.InputError, match=r"scenario.height.*bar.length"):
        jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.3))


LATCH = {"latch.stiffness": 2e3, "buffer.rebound_stiffness": 1e4}


@pytest.mark.parametrize(("turn", "angle", "much"), [(50.0, 0.05, True), (50.0, 0.001, False), (0.0, 0.05, False)])
def test_a_latch_that_puts_in_much_by_turning_is_said_before_a_run(turn, angle, much):
    """½ · 50 N m/rad · 0.05² is 62.5 mJ, of two vehicles of 20 kg at 0.1 m/s with 50 mJ; at 0.001 rad 25 µJ."""
    rods = {"buffer.cylinder_mass": 1e-3, "probe.rod_mass": 1e-3, "probe.tip_mass": 1e-3}
    changes = {**LATCH, "latch.turn_stiffness": turn, "active.mass": 20.0 - 3e-3, "passive.mass": 20.0, **rods}
    lines = [it for it in said(changes, jb.Scenario(misalignment=angle)) if it.startswith("closing the latch")]
    assert len(lines) == much
    if much:
        assert "62.5 mJ" in lines[0] and "(50 mJ): " in lines[0] and "1.2 times" in lines[0]
        assert lines[0].endswith("a smaller latch.turn_stiffness adds less")
        # A run measures it: its summary says that alone.
        after = said(changes, jb.Scenario(misalignment=angle), measured=False)
        assert not any("closing the latch" in it for it in after)


@pytest.mark.quick
def test_a_latch_without_a_rebound_stop_is_said():
    checks = PROBE_CONE.view.sanity_checks
    assert checks(jb.replace(jb.table2(), LATCH)) == []
    (line,) = checks(jb.replace(jb.table2(), {"latch.stiffness": 2e3}))
    assert line.startswith("a latch without buffer.rebound_stiffness: ") and "pulls" in line


TOLERANT = """
[problem.variables]
buffer.k_A = [100, 2000]
[tolerances]
probe.tip_radius = ["-0.2 mm", "0.5 mm"]
buffer.k_A = "5 %"
"""


def test_check_and_tune_look_at_the_corners_of_tolerances(tmp_path, capsys):
    """A ball of 15 mm passes a throat of 15 mm; with 0.5 mm more, in two of four corners, it does not. A stiffer spring
    is no matter of geometry, and the first of equal corners is named."""
    study = tmp_path / "study.toml"
    study.write_text(TOLERANT)
    problem = tuned_problem(load(study))
    reach = 0.0155 / ROOT2 - np.sqrt(0.0155**2 - 0.015**2)
    wide = [number for number, design, _ in problem.corner_runs if design.probe.tip_radius > 0.0151]
    line = "15.5 mm is above cone.throat_radius 15 mm: the ball does not pass the throat; it comes to rest on the"
    where = f"(scenario {wide[0]} and 1 more of 5)"
    told = capsys.readouterr().err
    assert len(wide) == 2 and line in told and f"{1e3 * reach:.3g} mm behind" in told and where in told
    assert command(["check", str(study)]) == 0
    assert where in capsys.readouterr().out


@pytest.mark.parametrize(("latch", "ends"), [("", "captured"), ("[latch]\nstiffness = 2000\n", "held or latched")])
def test_check_names_the_ends_that_a_design_can_have(tmp_path, capsys, latch, ends):
    study = tmp_path / "study.toml"
    study.write_text(f"{latch}[problem.constraints]\nstroke = 0.02\n")
    assert command(["check", str(study)]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "every load case must end" in line)
    assert line.endswith(f"must end {ends}")
