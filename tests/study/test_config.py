"""Studies: what TOML may say, what it may not, and that a written design reads back as it was."""

import jax.numpy as jnp
import pytest

from jaxbuffer import InputError, Limits, Objective, Scenario, SecondObjective, Variable, get, replace, table2
from jaxbuffer.fields import paths
from jaxbuffer.study.config import Config
from jaxbuffer.study.design_toml import design_toml
from jaxbuffer.study.load import load
from jaxbuffer.study.overrides import apply_overrides

TABLE2 = "optimise/table2.toml"


def read(tmp_path, text) -> Config:
    path = tmp_path / "study.toml"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_without_a_file_everything_is_table_2s():
    config = load(None)
    assert config.design == table2()
    assert config.scenarios == (config.scenario,) == (Scenario(),)
    assert (config.options.duration, config.options.rtol, config.options.solver) == (8.0, 1e-6, "automatic")


def test_the_shipped_study_is_table_2_at_three_speeds(request):
    config = load(request.config.rootpath / TABLE2)
    assert config.design == table2()
    assert [s.approach_speed for s in config.scenarios] == [0.1, 0.15, 0.2]
    assert config.scenario == config.scenarios[0]
    problem, default = config.problem(), Config().problem()
    assert problem.variables == default.variables and len(problem.variables) == 5
    assert problem.limits == default.limits and problem.limits.at_most == {"stroke": 0.025}
    assert problem.then is not None and problem.then.tolerance == 0.01


def test_every_section_is_read(tmp_path):
    config = read(
        tmp_path,
        """
        [buffer]
        k_A = 800            # an integer will do
        damping = "published"
        [probe]
        free_tip = true
        [contact]
        stiffness = 5e9
        [scenario]
        misalignment = 0.01
        [[scenarios]]
        approach_speed = 0.3
        [[scenarios]]
        [options]
        duration = 3
        rtol = 1e-9
        solver = "explicit"
        [tune]
        iterations = 7
        [problem.variables]
        buffer.k_A = [100, 2000]
        "probe.tip_mass" = [0.02, 0.2, "linear"]
        [problem.objective]
        peak_force = 1
        stroke = 1e4
        over = "cvar"
        level = 0.5
        [problem.constraints]
        impacts = 30
        stroke = 0.02
        [problem.then]
        end_time = 1
        """,
    )
    assert isinstance(config.design.buffer.k_A, float) and config.design.buffer.k_A == 800.0
    assert config.design.buffer.damping == "published" and config.design.probe.free_tip
    assert config.design.contact_stiffness == 5e9
    assert [s.approach_speed for s in config.scenarios] == [0.3, 0.1]
    assert {s.misalignment for s in config.scenarios} == {0.01}, "the list completes from [scenario]"
    assert config.scenario.approach_speed == 0.1
    assert (config.options.duration, config.options.rtol) == (3.0, 1e-9)
    assert type(config.options.stepper()).__name__ == "ExplicitRungeKutta"
    assert config.tuning.iterations == 7
    problem = config.problem()
    assert problem.variables == (
        Variable("buffer.k_A", 100.0, 2000.0),
        Variable("probe.tip_mass", 0.02, 0.2, "linear"),
    )
    assert problem.objective == Objective({"peak_force": 1, "stroke": 1e4}, "cvar", 0.5)
    assert problem.limits == Limits(True, {"stroke": 0.02}, 30)
    assert problem.then == SecondObjective(Objective({"end_time": 1}))
    assert problem.duration == 3.0 and problem.scenarios_met == config.scenarios


BAD = [
    # negative, zero and outside the range
    ("[active]\nmass = -1", ("active.mass = -1 kg", "(0, inf) kg")),
    ("[probe]\ntip_mass = 0", ("probe.tip_mass = 0 kg", "(0, inf) kg")),
    ("[buffer]\nk_A = 0.0", ("buffer.k_A = 0 N/m", "(0, inf) N/m")),
    ("[buffer]\nk_T = -3", ("buffer.k_T = -3 N m/rad", "(0, inf) N m/rad")),
    ("[probe]\ntip_radius = 0", ("probe.tip_radius = 0 m", "(0, ")),
    ("[cone]\nthroat_radius = -0.01", ("cone.throat_radius = -0.01 m", "(0, inf) m")),
    ("[contact]\nrestitution = 0", ("contact.restitution = 0", "(0, 1]")),
    ("[contact]\nrestitution = 1.2", ("contact.restitution = 1.2", "(0, 1]")),
    ("[contact]\nfriction = -0.1", ("contact.friction = -0.1", "[0, inf)")),
    ("[buffer]\nk_A = nan", ("buffer.k_A = nan N/m", "(0, inf) N/m")),
    ("[buffer]\nc_A = inf", ("buffer.c_A = inf N s/m", "[0, inf) N s/m")),
    ("[scenario]\npassive_rate = nan", ("scenario.passive_rate = nan rad/s", "(-inf, inf) rad/s")),
    # what does not fit together
    ("[probe]\ntip_radius = 0.07", ("probe.tip_radius = 0.07 m", "(0, 0.0669723) m")),
    ("[scenario]\ncontact_distance = 0.08", ("scenario.contact_distance = 0.08 m", "(0, 0.0735] m")),
    (
        "[[scenarios]]\n[[scenarios]]\ncontact_distance = 0.08",
        ("number 2", "contact_distance = 0.08 m", "(0, 0.0735] m"),
    ),
    ("[scenario]\nmisalignment = 0.8", ("scenario.misalignment = 0.8 rad", "(-0.785398, 0.785398) rad")),
    # unknown names
    ("[bufer]\nk_A = 1", ("[bufer] is unknown", "did you mean buffer?")),
    ("[buffer]\nkA = 1", ("buffer.kA is unknown", "did you mean buffer.k_A?")),
    ("[scenario]\naproach_speed = 1", ("scenario.aproach_speed is unknown", "did you mean scenario.approach_speed?")),
    ("[[scenarios]]\nspeed = 1", ("scenarios[1].speed is unknown",)),
    ("[options]\nrtoll = 1", ("options.rtoll is unknown", "did you mean options.rtol?")),
    ("[tune]\niteration = 1", ("tune.iteration is unknown", "did you mean tune.iterations?")),
    ("[problem.variables]\nbuffer.kA = [1, 2]", ("buffer.kA is unknown", "did you mean buffer.k_A?")),
    ("[buffer]\ndamping = 'phisical'", ("buffer.damping = 'phisical' is unknown", "did you mean physical?")),
    ("[options]\nsolver = 'implicid'", ("options.solver = 'implicid' is unknown", "did you mean implicit?")),
    # TOML types
    ("[buffer]\nk_A = '800'", ("buffer.k_A = '800': a text needs a unit", "(0, inf) N/m")),
    ("[buffer]\nk_A = true", ("buffer.k_A: 'true' is not a number", "(0, inf) N/m")),
    ("[buffer]\nk_A = [1, 2]", ("buffer.k_A: '[1, 2]' is not a number", "(0, inf) N/m")),
    ("[buffer]\nk_A = 2026-01-01", ("buffer.k_A: '2026-01-01' is not a number", "(0, inf) N/m")),
    ("[options]\nrtol = 'small'", ("options.rtol: 'small' is not a number", "[1e-13, 0.01]")),
    ("[probe]\nfree_tip = 1", ("probe.free_tip = 1 must be true or false",)),
    ("[tune]\niterations = 2.5", ("tune.iterations = 2.5 must be a whole number of at least 1",)),
    ("[tune]\niterations = true", ("tune.iterations = True must be a whole number",)),
    ("buffer = 3", ("buffer = 3 is not a table", "[buffer]")),
    ("[scenarios]\napproach_speed = 1", ("scenarios is not a list of tables", "[[scenarios]]")),
    ("[problem]\nvariables = 1", ("problem.variables = 1 is not a table",)),
    ("[problem]\nobjectiv = 1", ("problem.objectiv is unknown", "did you mean objective?")),
    ("[problem.objective]\npeak_forc = 1", ("problem.objective.peak_forc is unknown", "did you mean peak_force?")),
    ("[problem.objective]\npeak_force = -1", ("objective.peak_force = -1 N/N", "(0, inf)")),
    ("[problem.objective]\nover = 'wurst'", ("objective.over = 'wurst' is unknown", "did you mean worst?")),
    ("[problem.objective]\nlevel = 1", ("objective.level = 1", "[0, 1)")),
    ("[problem.constraints]\nstrok = 1", ("problem.constraints.strok is unknown", "did you mean stroke?")),
    ("[problem.constraints]\nstroke = -0.1", ("problem.constraints.stroke = -0.1 m", "(0, inf) m")),
    ("[problem.constraints]\nimpacts = 2.5", ("constraints.impacts = 2.5 must be a whole number of at least 1",)),
    ("[problem.constraints]\nrequire_success = 1", ("constraints.require_success = 1 must be true or false",)),
    ("[problem.then]\ntolerance = 0.1", ("problem.then names no quantity",)),
    ("[problem.then]\nstroke = 1\ntolerance = 0", ("then.tolerance = 0", "(0, 1]")),
    ("[problem.grid]\napproach_speed = []", ("problem.grid.approach_speed = []", "list of numbers in m/s")),
    ("[problem.grid]\nspeed = [1]", ("problem.grid.speed is unknown",)),
    (
        "[problem.grid]\nmisalignment = [0]\n[problem.sample]\nscenario.misalignment = {uniform = [0, 1]}",
        ("problem.sample.scenario.misalignment and problem.grid.misalignment", "keep one"),
    ),
    ("[problem.sample]\ncount = 0\nscenario.approach_speed = {uniform = [1, 2]}", ("sample.count = 0",)),
    ("[problem.sample]\ncount = 4", ("nothing scatters",)),
    ("[problem.sample]\nscenario.approach_speed = 1", ("approach_speed = 1", "{ uniform = [low, high] }")),
    ("[problem.sample]\nfactors.buffer.kA = {uniform = [1, 2]}", ("factors.buffer.kA is unknown", "buffer.k_A?")),
    # settings
    ("[options]\nduration = 0", ("options.duration = 0 s", "(0, inf) s")),
    ("[options]\nrtol = 0.1", ("options.rtol = 0.1", "[1e-13, 0.01]")),
    ("[tune]\ntolerance = 0", ("tune.tolerance = 0", "(0, 1)")),
    ("[problem.variables]", ("problem.variables is empty",)),
    ("[problem.variables]\nbuffer.k_A = [100]", ("problem.variables.buffer.k_A = [100]", "[low, high] in N/m")),
    ("[problem.variables]\nbuffer.k_A = [1, 2, 'cubic']", ("scale = 'cubic' is unknown", "log, linear")),
    ("[problem.variables]\nbuffer.k_A = [2e3, 1e2]", ("[2000, 100] N/m", "low bound must be below")),
    ("[problem.variables]\nbuffer.k_A = [-1, 1e3]", ("problem.variables.buffer.k_A = -1 N/m", "(0, inf) N/m")),
    ("[problem.variables]\nbuffer.damping = [1, 2]", ("buffer.damping is a choice",)),
    # syntax
    ("[buffer\nk_A = 1", ("study.toml is not valid TOML", "line 1")),
    ("[buffer]\nk_A = \n", ("study.toml is not valid TOML", "line 2")),
]


@pytest.mark.parametrize(("text", "parts"), BAD, ids=[text.replace("\n", " ") for text, _ in BAD])
def test_bad_input_is_one_line_with_field_value_unit_and_range(tmp_path, text, parts):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    message = str(caught.value)
    assert "\n" not in message and message.startswith(str(tmp_path / "study.toml"))
    for part in parts:
        assert part in message


def test_files_that_can_not_be_read(tmp_path):
    with pytest.raises(InputError, match=r"missing\.toml: no such file"):
        load(tmp_path / "missing.toml")
    with pytest.raises(InputError, match=r"a folder, not a study; give a file that ends in \.toml"):
        load(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b"# \xe9")
    with pytest.raises(InputError, match=r"latin\.toml is not valid TOML: .*utf-8"):
        load(tmp_path / "latin.toml")


def test_the_start_must_lie_within_the_bounds_of_tuning(tmp_path):
    config = read(tmp_path, "[problem.variables]\nbuffer.k_A = [600, 2000]")
    with pytest.raises(InputError, match=r"the start, buffer\.k_A = 500 N/m, is outside its bounds \[600, 2000\] N/m"):
        config.problem()
    assert apply_overrides(config, {"buffer.k_A": "700"}).problem().design.buffer.k_A == 700.0


def test_overrides_replace_fields_of_every_type():
    config = apply_overrides(
        Config(),
        {"buffer.k_A": "8e2", "probe.free_tip": "true", "contact.memory": "smooth", "scenario.misalignment": "-0.1"},
    )
    assert (config.design.buffer.k_A, config.design.probe.free_tip, config.design.contact.memory) == (
        800.0,
        True,
        "smooth",
    )
    assert config.scenario.misalignment == -0.1 and config.scenarios == (config.scenario,)
    modes = apply_overrides(Config(), {"probe.bending_modes": "3"}).design.probe.bending_modes
    assert modes == 3 and type(modes) is int


def test_an_overridden_scenario_field_holds_for_all_and_leaves_no_twins():
    config = Config(scenarios=(Scenario(approach_speed=0.1), Scenario(approach_speed=0.2)))
    assert [s.passive_rate for s in apply_overrides(config, {"scenario.passive_rate": "0.01"}).scenarios] == [
        0.01,
        0.01,
    ]
    assert apply_overrides(config, {"scenario.approach_speed": "0.3"}).scenarios == (Scenario(approach_speed=0.3),)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("buffer.kA", "1", r"buffer\.kA is unknown; did you mean buffer\.k_A\?"),
        ("scenario.speed", "1", r"scenario\.speed is unknown"),
        ("options.rtol", "1", r"options\.rtol is unknown"),
        ("buffer.k_A", "much", r"buffer\.k_A: 'much' is not a number; expected \(0, inf\) N/m"),
        ("buffer.k_A", "nan", r"buffer\.k_A = nan N/m is out of range; allowed: \(0, inf\) N/m"),
        (
            "scenario.approach_speed",
            "-1",
            r"scenario\.approach_speed = -1 m/s is out of range; allowed: \(0, inf\) m/s",
        ),
        (
            "scenario.contact_distance",
            "1",
            r"scenario\.contact_distance = 1 m is out of range; allowed: \(0, 0\.0735\] m",
        ),
        ("contact.arms", "fixed", r"contact\.arms = 'fixed' is unknown; choose one of moving, published"),
        ("probe.bending_modes", "2.5", r"probe\.bending_modes = 2\.5 must be a whole number of at least 2"),
        ("probe.free_tip", "perhaps", r"probe\.free_tip = 'perhaps' must be true or false"),
    ],
)
def test_bad_overrides(path, value, message):
    with pytest.raises(InputError, match=message):
        apply_overrides(Config(), {path: value})


def test_a_written_design_reads_back_to_the_same_numbers(tmp_path):
    awkward = {"buffer.k_A": 0.1 + 0.2, "contact.stiffness": 1e10 / 3, "probe.tip_mass": jnp.asarray(2.0) / 41}
    design = replace(table2(), {**awkward, "buffer.damping": "published", "probe.free_tip": True})
    scenarios = (Scenario(approach_speed=1 / 7), Scenario(misalignment=-1e-17))
    path = tmp_path / "design.toml"
    path.write_text(design_toml(design, scenarios, "tuned\nin a test"), encoding="utf-8")
    config = load(path)
    assert {p: get(config.design, p) for p in paths(design)} == {p: get(design, p) for p in paths(design)}
    assert config.scenarios == scenarios
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# tuned\n# in a test\n\n[active]\n")
    assert "k_A = 0.30000000000000004  # N/m" in text


def test_an_unset_stiffness_stays_unset(tmp_path):
    assert "\nstiffness" not in design_toml(table2())
    assert read(tmp_path, design_toml(table2())).design.contact.stiffness is None
