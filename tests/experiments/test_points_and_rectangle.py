"""Points evenly spread, and the largest rectangle, against what can be counted."""

import itertools

import numpy as np
import pytest
from scipy.stats import sobol_indices, uniform

import jaxbuffer as jb
from jaxbuffer.experiments.indices import estimated, estimators
from jaxbuffer.experiments.points import points
from jaxbuffer.experiments.ranges import Range, ranges
from jaxbuffer.experiments.rectangle import largest_rectangle


def test_a_latin_hypercube_has_a_point_in_every_slice_and_sobol_in_every_box():
    axes = [Range("a", "m", 0.0, 1.0)] * 2
    hyper = points(axes, 50, "latin_hypercube", 3)
    for k in range(2):
        assert np.array_equal(np.sort((50 * hyper.shares[:, k]).astype(int)), np.arange(50))
    sobol = points(axes, 64, "sobol", 3)  # a (0, m, 2)-net: each elementary box of area 1/64 has one point
    for across in (1, 2, 4, 8, 16, 32, 64):
        boxes = {(int(x * across), int(y * 64 // across)) for x, y in sobol.shares}
        assert len(boxes) == 64
    assert np.array_equal(points(axes, 64, "sobol", 3).shares, sobol.shares), "the same seed, the same points"


def test_the_scale_is_logarithmic_beyond_a_decade_or_as_asked():
    asked = {"buffer.k_A": (100.0, 2000.0), "buffer.c_A": (1.0, 10.0), "probe.tip_mass": (0.02, 0.2, "log")}
    assert [a.scale for a in ranges(asked, jb.table2(), jb.Scenario())] == ["log", "linear", "log"]
    (k, *_) = ranges(asked, jb.table2(), jb.Scenario())
    assert np.allclose(k.at(np.array([0.0, 0.5, 1.0])), [100.0, np.sqrt(2e5), 2000.0], rtol=1e-14, atol=0.0)
    assert np.allclose(k.shares(k.at(np.array([0.1, 0.9]))), [0.1, 0.9], rtol=1e-12, atol=0.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_largest_rectangle_is_the_one_of_trying_all(seed):
    rng = np.random.default_rng(seed)
    for shape in ((1, 1), (1, 7), (6, 1), (5, 7), (8, 6)):
        mask = rng.random(shape) < 0.3 + 0.12 * seed
        spans = [list(itertools.combinations(range(n + 1), 2)) for n in shape]
        best = max((((b - a) * (d - c)) for a, b in spans[0] for c, d in spans[1] if mask[a:b, c:d].all()), default=0)
        rows, columns = largest_rectangle(mask)
        assert mask[rows, columns].all()
        assert (rows.stop - rows.start) * (columns.stop - columns.start) == best


ISHIGAMI = [Range(name, "rad", -np.pi, np.pi) for name in "abc"]
A, B = 7.0, 0.1
VARIANCE = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5
FIRST = np.array([0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0]) / VARIANCE
TOTAL = FIRST + np.array([1, 0, 1]) * 8 * B**2 * np.pi**8 / 225 / VARIANCE


def ishigami(x):
    return np.sin(x["a"]) + A * np.sin(x["b"]) ** 2 + B * x["c"] ** 4 * np.sin(x["a"])


def test_indices_of_ishigami_are_those_of_its_closed_form(evidence):
    source = "Ishigami and Homma 1990; closed form in Saltelli et al., Global Sensitivity Analysis, 2008"
    found = estimated(ishigami(points(ISHIGAMI, 2**13, "saltelli").columns()), 3)
    for what, mine, exact in (("first-order", found.first, FIRST), ("total", found.total, TOTAL)):
        error = np.max(np.abs(mine - exact))
        evidence("Design of experiments", f"{what} Sobol' indices of Ishigami's function", error, 5e-3, source, "-")


def test_intervals_hold_the_true_index_about_as_often_as_they_say(evidence):
    held = []
    for seed in range(40):
        found = estimated(ishigami(points(ISHIGAMI, 256, "saltelli", seed).columns()), 3, resamples=199, seed=seed)
        for (low, high), exact in ((found.first_interval, FIRST), (found.total_interval, TOTAL)):
            held.append((low <= exact) & (exact <= high))
    missed = 1.0 - float(np.mean(held))
    source, claim = "closed form, 40 samples of 256 rows", "share of 95 % intervals that miss the true index"
    evidence("Design of experiments", claim, missed, 0.10, source, "-")


def test_the_estimators_are_scipys(evidence):
    spread = points(ISHIGAMI, 512, "saltelli")
    blocks = ishigami(spread.columns()).reshape(5, -1)
    mine = estimators(blocks - blocks[:2].mean())
    given = {"f_A": blocks[:1], "f_B": blocks[1:2], "f_AB": blocks[2:, None, :]}
    theirs = sobol_indices(func=given, n=512)
    error = max(np.max(np.abs(mine[0] - theirs.first_order)), np.max(np.abs(mine[1] - theirs.total_order)))
    evidence("Design of experiments", "estimators of Sobol' indices", error, 1e-12, "scipy.stats.sobol_indices", "-")
    whole = sobol_indices(
        func=lambda x: ishigami(dict(zip("abc", x, strict=True))),
        n=512,
        dists=[uniform(-np.pi, 2 * np.pi)] * 3,
        rng=np.random.default_rng(0),
    )
    assert np.max(np.abs(whole.total_order - theirs.total_order)) < 0.1, "the same scheme, other points"


def test_rows_with_a_run_left_out_are_left_out_whole():
    values = ishigami(points(ISHIGAMI, 64, "saltelli").columns())
    values[[3, 64 + 7, 3 * 64 + 7]] = np.nan
    assert estimated(values, 3).rows == 62
    values[:60] = np.nan
    with pytest.raises(jb.InputError, match="4 rows of the sample"):
        estimated(values, 3, name="peak_force")
    with pytest.raises(jb.InputError, match="no variance"):
        estimated(np.ones(5 * 64), 3)
