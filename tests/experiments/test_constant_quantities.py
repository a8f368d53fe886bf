"""Indices and surfaces of what does not vary: refused, also where rounding makes it vary a little."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.experiments.indices import estimated
from jaxbuffer.experiments.points import points
from jaxbuffer.experiments.ranges import ranges
from jaxbuffer.experiments.sample import Sample
from jaxbuffer.mechanisms import mechanism_named
from jaxbuffer.sweeps.columns import column_names

SPREAD = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.05, 0.2)}
NOISE = 3e-9  # relative, as runs differ by their steps


def made_up(method: str, count: int, **columns) -> Sample:
    """Bar drops whose quantities are functions of the two shares, (n, 2)."""
    mechanism, design, scenario = mechanism_named("bar_drop"), jb.BarDrop(), jb.BarDropScenario()
    grid = points(ranges(SPREAD, design, scenario), count, method)
    found = {name: np.zeros(len(grid), int) for name in column_names(mechanism)}
    found |= {name: np.ones(len(grid)) for name in mechanism.swept}
    found |= {name: of(grid.shares) for name, of in columns.items()}
    return Sample(mechanism, found, design, scenario, grid)


def rounding(shares: np.ndarray) -> np.ndarray:
    """What steps leave: it depends on the numbers, but by no effect of theirs."""
    return np.sin(1e4 * shares @ np.array([1.0, 3.0]))


@pytest.mark.parametrize("method", ["saltelli", "sobol"])
@pytest.mark.parametrize(
    "of",
    [
        lambda shares: np.full(len(shares), 0.25),
        lambda shares: 0.25 * (1.0 + NOISE * rounding(shares)),
        lambda shares: 1e-12 * rounding(shares),  # m, beside a penetration of 1 m: zero but for rounding
        lambda shares: np.zeros(len(shares)),
    ],
    ids=["constant", "rounded", "rounded zero", "zero"],
)
def test_what_does_not_vary_is_refused(method, of):
    lengths = [name for name in mechanism_named("bar_drop").swept if name != "penetration"]
    name = next(it for it in lengths if mechanism_named("bar_drop").quantities[it].unit == "m")
    sample = made_up(method, 64, **{name: of})
    with pytest.raises(jb.InputError, match=f"^indices of {name}: it is the same in all runs"):
        jb.sobol_indices(sample, [name])
    with pytest.raises(jb.InputError, match=f"^response surface of {name}: it is the same in all runs"):
        jb.response_surface(sample, name)


def test_what_varies_little_is_not():
    """A part in ten thousand, of the first number alone."""
    sample = made_up("saltelli", 64, peak_force=lambda shares: 100.0 + 0.01 * shares[:, 0])
    found = jb.sobol_indices(sample, ["peak_force"]).estimates["peak_force"]
    assert found.total[0] == pytest.approx(1.0, abs=0.05) and found.total[1] == pytest.approx(0.0, abs=1e-12)


def test_estimates_of_rounding_alone_are_refused():
    sample = made_up("saltelli", 64)
    with pytest.raises(jb.InputError, match="the same in all runs but for rounding"):
        estimated(1.0 + NOISE * rounding(sample.grid.shares), 2, name="peak_force")


@pytest.mark.slow
def test_a_constant_takes_nothing_from_the_others(monkeypatch, tmp_path, capsys):
    from jaxbuffer.cli.commands import sample as command
    from jaxbuffer.cli.entry import run

    made = made_up("saltelli", 64, peak_force=lambda shares: 100.0 + shares[:, 0])
    monkeypatch.setattr(command, "computed_runs", lambda *asked, **options: (dataclasses.replace(made), False))
    (tmp_path / "drop.toml").write_text('kind = "bar_drop"')
    words = ["--over", "impact.stiffness=1e10:1e12", "--count", "64", "--of", "peak_force", "--of", "penetration"]
    out = tmp_path / "out"
    code = run(["sample", str(tmp_path / "drop.toml"), *words, "--indices", "--surface", "--output", str(out)])
    assert code == 2 and "of penetration: it is the same in all runs" in capsys.readouterr().err
    assert "peak_force" in (out / "indices.csv").read_text() and "peak_force" in (out / "surface.csv").read_text()
    assert "nan" not in (out / "sample.txt").read_text()
