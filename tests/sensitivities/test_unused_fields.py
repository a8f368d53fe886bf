"""A field that changes nothing has derivatives of exactly zero, alone and with others; one that changes something not.

What a field changes is seen in plain runs, which know nothing of derivatives.
"""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.errors import InputError
from jaxbuffer.fields import why_inactive

RUNS = {
    "probe_cone": (jb.table2(), jb.Scenario(), 0.2),
    "bar_drop": (jb.BarDrop(), jb.BarDropScenario(height=0.05), 0.15),
    "slider_crank": (jb.SliderCrank(), jb.SliderCrankScenario(), 1e-3),
}
QUANTITIES = ("peak_force", "contact_time", "penetration", "end_time")
each_mechanism = pytest.mark.parametrize("name", RUNS)


def numbers(name):
    """Addresses and values of a design's and scenario's numbers."""
    design, scenario, _ = RUNS[name]
    values = {path: jb.get(design, path) for path in jb.paths(design)}
    values |= {f"scenario.{path}": jb.get(scenario, path) for path in jb.paths(scenario)}
    return {path: float(value) for path, value in values.items() if isinstance(value, (float, jax.Array))}


def outputs(name, values):
    """Quantities of a run with some numbers changed."""
    design, scenario, duration = RUNS[name]
    met = {path.removeprefix("scenario."): x for path, x in values.items() if path.startswith("scenario.")}
    parts = {path: x for path, x in values.items() if not path.startswith("scenario.")}
    run = jb.simulate(jb.replace(design, parts), jb.replace(scenario, met), duration)
    return jnp.stack([run.quantity(quantity) for quantity in QUANTITIES])


# It stands in the height of the fall and in the gap alike, so that it moves a run by rounding, or not at all.
ROUNDING = {"bar.ball_radius"}


@functools.cache
def changing(name):
    """Which numbers change a run's quantities, each moved by a thousandth."""
    values = numbers(name)
    of = jax.jit(functools.partial(outputs, name))
    before = np.asarray(of(values))
    assert np.all(np.isfinite(before))
    after = {path: np.asarray(of(values | {path: value * 1.001 + 1e-6})) for path, value in values.items()}
    np.testing.assert_allclose([after[path] for path in ROUNDING & after.keys()] or [before], [before], rtol=1e-10)
    changes = {path: not np.array_equal(changed, before) for path, changed in after.items()}
    return {path: them for path, them in changes.items() if path not in ROUNDING}


def moved(name, chosen):
    """How all quantities change as the chosen numbers change at different rates."""
    values = {path: numbers(name)[path] for path in chosen}
    rates = {path: 1.0 + 0.37 * k for k, path in enumerate(chosen)}
    return np.asarray(jax.jit(lambda values: jax.jvp(functools.partial(outputs, name), (values,), (rates,))[1])(values))


def split(name):
    """The numbers that change nothing, and those that do."""
    changes = changing(name)
    return [path for path in changes if not changes[path]], [path for path in changes if changes[path]]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "bar_drop" else pytest.mark.long) for name in RUNS]
)
def test_fields_that_do_nothing_have_no_derivatives(name):
    """All of them together, without any that does something beside them."""
    unused, _ = split(name)
    assert len(unused) >= 2
    np.testing.assert_array_equal(moved(name, unused), np.zeros(len(QUANTITIES)))


# What the short runs here do not come to: the far end of a flank.
ELSEWHERE = {"cone.length"}


@pytest.mark.slow
@each_mechanism
def test_a_field_is_said_to_have_no_effect_exactly_where_no_number_of_a_run_moves(name):
    """What the declarations beside the fields say is held against whole runs. Some of those fields cannot be set at all
    while what they need is missing."""
    design, scenario, _ = RUNS[name]
    said = {path for path in changing(name) if why_inactive(design, scenario, path)}
    unused = set(split(name)[0])
    assert unused - said <= ELSEWHERE
    for path in said - unused:
        with pytest.raises(InputError):
            jb.replace(design, {path: numbers(name)[path] + 0.1})


@pytest.mark.long
@pytest.mark.parametrize("name", ["bar_drop", "slider_crank"])
def test_a_field_that_does_nothing_alone(name):
    """By itself, forward and reverse; and beside one that does something, which has a derivative then."""
    unused, used = split(name)
    for path in unused[:: max(1, len(unused) // 3)]:
        np.testing.assert_array_equal(moved(name, [path]), np.zeros(len(QUANTITIES)), err_msg=path)
    pair = {path: numbers(name)[path] for path in (unused[0], used[0])}
    of = jax.jit(jax.grad(lambda values: jnp.sum(outputs(name, values))))
    backwards = of(pair)
    assert float(backwards[unused[0]]) == 0.0
    assert float(backwards[used[0]]) != 0.0
    assert float(of({unused[0]: pair[unused[0]]})[unused[0]]) == 0.0
