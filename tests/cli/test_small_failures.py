"""Small failures that people met: each is an answer, or one line that says what to write."""

import warnings

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.sensitivities.certificate import peak_report
from jaxbuffer.study.load import loads
from jaxbuffer.tuning.pareto import limits_between
from made_up import made_up_capture


@pytest.mark.parametrize(
    ("slopes", "path", "change"), [((1.0, 1.0), "", np.inf), ((1.0, 2.0), "buffer.k_A", 0.0)], ids=["alike", "apart"]
)
def test_two_equal_peaks_swap_at_once_or_never(slopes, path, change):
    capture = made_up_capture()
    hits = capture.impacts
    hits = eqx.tree_at(lambda it: (it.peak_force, it.count), hits, (jnp.array([250.0, 250.0, 0.0]), jnp.asarray(2)))
    capture = eqx.tree_at(lambda it: it.impacts, capture, hits)
    with warnings.catch_warnings(action="error"):
        peaks = peak_report(capture, 250.0 * np.array([[slopes[0]], [slopes[1]], [0.0]]), ["buffer.k_A"])
    assert (peaks.margin, peaks.swap_path, peaks.swap_change) == (0.0, path, change)


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        ("sweep --over scenario.approach_speed=0.1:0.2:1e30", "count = 1e+30 is out of range; allowed: [1, 1e+15]"),
        ("sweep --over scenario.approach_speed=0.1:0.2:1e19:log", "count = 1e+19 is out of range; allowed: [1, 1e+15]"),
        ("sweep --over buffer.k_A=1:2:100000000 --over buffer.c_A=1:2:100000000", "= 1e+16 runs, which need"),
        ("tune --starts 1e30", "must be a whole number from 1 to 1048576"),
        ("sample --over scenario.approach_speed=0.1:0.2 --count 1e30", "--count 1e30 is not a whole number"),
        ("animate --output a.html", "format = 'html'"),
        ("animate --output a.mp4 --format gif", "--format gif and --output a.mp4 contradict; keep one"),
        ("simulate --output results/run.json", "names a folder; write --output results/run"),
        ("simulate --buffer.k_A 0,5", "buffer.k_A = '0,5': numbers have a decimal point here; write 0.5;"),
        ("simulate --duration 1,5", "--duration = '1,5': numbers have a decimal point here; write 1.5;"),
    ],
)
def test_a_command_that_cannot_be_is_one_line(computed, capsys, tmp_path, words, shown):
    assert run(words.split()) == 2
    error = capsys.readouterr().err
    assert shown in error and error.count("\n") == 1
    assert not list(tmp_path.iterdir())


TEXTS = {
    '[buffer]\nk_A = "500"': """buffer.k_A = '500': a text needs a unit; write 500 without quotes, or "500 N/m";""",
    '[contact]\nfriction = "0.1"': "contact.friction = '0.1': a text needs a unit; write 0.1 without quotes;",
    '[buffer]\nk_A = "0,5 kN/m"': "buffer.k_A = '0,5 kN/m': numbers have a decimal point here; write 0.5 kN/m;",
    '[scenario]\nmisalignment = "-1,5e-1 deg"': "numbers have a decimal point here; write -1.5e-1 deg;",
    '[problem.variables]\nbuffer.k_A = ["1", "2"]': "problem.variables.buffer.k_A = '1': a text needs a unit;",
    '[problem.constraints]\nstroke = "0,025 m"': "numbers have a decimal point here; write 0.025 m;",
    '[problem.grid]\napproach_speed = ["0,1 m/s"]': "numbers have a decimal point here; write 0.1 m/s;",
    '[sample.ranges]\nbuffer.k_A = ["1", "2"]': "sample.buffer.k_A = '1': a text needs a unit;",
    '[buffer]\nk_A = "1,2,3"': "buffer.k_A: '1,2,3' is not a number;",
}


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_says_what_it_lacks(text):
    with pytest.raises(jb.InputError) as error:
        loads(text.encode(), "study.toml")
    assert TEXTS[text] in str(error.value)


@pytest.mark.parametrize("number", ["0.1", "12", "1e2", ".5", "101", "1.1"])
def test_no_digit_of_a_number_is_taken_for_its_unit(number):
    """A unit may begin with 1, as 1/s does."""
    with pytest.raises(jb.InputError, match=f"a text needs a unit; write {number} without quotes"):
        jb.Scenario(passive_rate=number)


NAMES = {
    "[problem.then]\ntoleranse = 0.1": "problem.then.toleranse is unknown; did you mean tolerance?",
    "[problem.then]\nstroke = 1.0\ntoleranse = 0.1": "problem.then.toleranse is unknown; did you mean tolerance?",
    "[problem.then]\nstrok = 1.0": "problem.then.strok is unknown; did you mean stroke?",
    "[problem.then]\ntolerance = 0.1": "problem.then names no quantity",
    '[problem.objective]\novr = "worst"': "problem.objective.ovr is unknown; did you mean over?",
    "[problem.sample.scenario]\napproach_speed = {unifrm = [0.1, 0.2]}": "unifrm is unknown; did you mean uniform?",
    "[problem.sample.factors]\nbuffer.k_A = {norml = [1, 0.1]}": "norml is unknown; did you mean normal?",
    '[sample]\nmethod = "sobl"': "sample.method = 'sobl' is unknown; choose one of sobol,",
    "[buffer]\nk_B = 1.0": "did you mean buffer.k_A?",
    "[scenario]\naproach_speed = 1.0": "did you mean scenario.approach_speed?",
    "[[scenarios]]\naproach_speed = 1.0": "did you mean scenarios[1].approach_speed?",
    "[options]\nrtoll = 1e-6": "did you mean options.rtol?",
    "[tune]\nitertions = 3": "did you mean tune.iterations?",
    "[sweep]\nscenario.approach_speed = {from = 0.1, too = 0.2, count = 3}": "did you mean to?",
    "[sample]\ncout = 4": "did you mean count?",
    "[problem]\nvarables = 1": "did you mean variables?",
    "[problem.variables]\nbuffer.k_B = [1, 2]": "did you mean buffer.k_A?",
    "[problem.constraints]\nrequire_succes = true": "did you mean require_success?",
    "[problem.constraints]\nstroke = {mn = 1}": "did you mean min?",
    "[problem.grid]\naproach_speed = [0.1]": "did you mean approach_speed?",
    '[problem.quantities]\neffort = {functon = "a.py:b", unit = "N"}': "did you mean function?",
}


@pytest.mark.parametrize("text", NAMES)
def test_every_section_suggests_the_nearest_name(text):
    with pytest.raises(jb.InputError) as error:
        loads(text.encode(), "study.toml")
    assert NAMES[text] in str(error.value)


def test_an_objective_that_can_be_brought_to_zero_is_traded():
    """Its tightest limit is a thousandth of its largest value: limits are positive."""
    ends = np.array([[8.0, 5.0], [0.0, 9.0], [4.0, 2.0]])  # of two objectives at the ends of three
    first, second = limits_between(ends, 3)
    assert first == pytest.approx([8.0, 4.004, 0.008]) and second == pytest.approx([9.0, 5.501, 2.002])


@pytest.mark.slow
def test_an_objective_that_is_zero_is_named():
    """A drop that ends before the ball rises rebounds to 0 m."""
    variables = [jb.Variable("impact.stiffness", 1e10, 1e12)]
    problem = jb.Problem(jb.BarDrop(), [jb.BarDropScenario(height=0.01)], variables, duration=0.06)
    with pytest.raises(jb.InputError, match="pareto: rebound_height is 0 wherever an objective is least"):
        jb.pareto(problem, ["peak_force", "rebound_height"], points=2, starts=1, iterations=1)


def test_histories_at_no_times_and_at_what_are_none():
    drop = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.01), 0.06, history=True)
    nothing, some = jb.at_times(drop, []), jb.at_times(drop, [0.01, 0.02])
    assert nothing.time.shape == (0,) and nothing.position.shape == (0, *some.position.shape[1:])
    for times in (0.01, np.zeros((2, 2)), "0.01 s", [0.01, np.nan], [[0.01], [0.02, 0.03]], None):
        with pytest.raises(jb.InputError, match=r"^times = .*: expected an array \(n,\) of times \[s\]"):
            jb.at_times(drop, times)


def test_an_animation_s_file_may_be_named(monkeypatch, computed, tmp_path):
    monkeypatch.setattr("jaxbuffer.cli.commands.animate.animation", lambda run, kind, report: f"a {kind}".encode())
    assert run(["animate", "--output", "films/docking.GIF"]) == 0
    assert run(["animate", "--output", "films"]) == 0
    assert {file.name: file.read_bytes() for file in (tmp_path / "films").iterdir()} == {
        "docking.GIF": b"a gif",
        "motion.gif": b"a gif",
    }
    assert run(["animate", "--output", "films/docking.GIF"]) == 2, "it exists"
