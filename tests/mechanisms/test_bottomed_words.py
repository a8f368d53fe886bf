"""What a bottomed run says: how much stroke it lacks is known only to a run that has it."""

import numpy as np
import pytest

import jaxbuffer as jb

ROOM = 0.59  # m, more stroke than any of these runs needs


def vehicles(rng):
    """Two vehicles from 20 kg to 5 t, and a buffer that takes them up within some centimetres."""
    masses, speed = np.exp(rng.uniform(np.log(20.0), np.log(5000.0), 2)), rng.uniform(0.05, 0.4)
    reduced = masses[0] * masses[1] / masses.sum()
    stiffness = reduced * speed**2 / rng.uniform(0.05, 0.2) ** 2
    damping = 2.0 * rng.uniform(0.02, 0.4) * np.sqrt(stiffness * reduced)
    values = {"active.mass": masses[0], "active.inertia": 0.03 * masses[0], "passive.mass": masses[1]}
    values |= {"passive.inertia": 0.03 * masses[1], "buffer.k_A": stiffness, "buffer.c_A": damping}
    values |= {"buffer.free_length": 0.6, "buffer.max_stroke": ROOM}
    return jb.replace(jb.table2(), {path: float(x) for path, x in values.items()}), jb.Scenario(float(speed))


@pytest.mark.long
def test_the_cure_is_named_and_no_amount():
    """Of 30 random designs, cut to a share of the stroke that each needs: the margin is off by far, either way, so that
    no amount is said; the cure that is named, with the stroke that the longer run used, is one."""
    rng, shares = np.random.default_rng(7), []
    while len(shares) < 30:
        design, scenario = vehicles(rng)
        long = jb.simulate(design, scenario, 8.0)
        if long.outcome.failed or long.outcome.name == "bottomed":
            continue
        needed = float(long.stroke)
        cut = needed * float(rng.uniform(0.3, 0.95))
        short = jb.simulate(jb.replace(design, {"buffer.max_stroke": cut}), scenario, 8.0)
        assert short.outcome.name == "bottomed"
        shares.append(-float(short.stroke_margin) / (needed - cut))
        (line,) = (line for line in repr(short).splitlines() if "margin" in line)
        assert "raise buffer.max_stroke, buffer.k_A or buffer.c_A" in line and " mm" not in line
        cured = jb.simulate(jb.replace(design, {"buffer.max_stroke": 1.001 * needed}), scenario, 8.0)
        assert cured.outcome == long.outcome and float(cured.stroke) == pytest.approx(needed, rel=1e-4)
    assert min(shares) < 0.02 and np.median(shares) < 0.2, "so the amount it would have said is wrong by factors"
