"""Pictures of a run: where bodies and forces are drawn, what lies between the steps, frames of an animation."""

import io
import types

import matplotlib
import numpy as np
import pytest
from PIL import Image
from scipy.integrate import solve_ivp

import jaxbuffer as jb
from jaxbuffer.contact import Segment
from jaxbuffer.mechanisms.drawing import (
    GROUND,
    Band,
    Detail,
    Disc,
    Drawing,
    Outline,
    RodShape,
    Spot,
    Touch,
    plain_drawing,
    stations,
    with_stations,
)
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.mechanisms.view import View
from jaxbuffer.multibody import Coordinates
from jaxbuffer.multibody.flexible import Bar, pinned_bar
from jaxbuffer.output import animation
from jaxbuffer.output.motion import draw, telling_times
from jaxbuffer.output.pulses import pulse_around, pulses
from jaxbuffer.output.sketch import outline
from jaxbuffer.run.instants import at_times
from output.drawn import check_readable

UNDAMPED = {"impact.damping": 0.0}
PEAK, AT = 550.2013, 0.2115196  # N, s: computed independently for the dropped bar without a damper


@pytest.fixture(scope="module")
def drop():
    """A bar that falls on a plate without a damper."""
    return jb.simulate(jb.replace(jb.BarDrop(), UNDAMPED), jb.BarDropScenario(), 0.23, history=True)


def bar_force(times):
    """Contact force [N] of the dropped bar, by another program: one equation for the bar's angle."""
    length, gravity, stiffness, exponent, height = 0.24, 9.81, 48_049.0 * 1000.0**2.2, 2.2, 0.194
    mass = 7850.0 * np.pi / 4.0 * 0.004**2 * length

    def depth(angle):
        return np.maximum(-length * np.sin(angle), 0.0)

    def rate(time, y):
        moment = (stiffness * depth(y[0]) ** exponent - 0.5 * mass * gravity) * length * np.cos(y[0])
        return [y[1], moment / (mass * length**2 / 3.0)]

    level = solve_ivp(rate, (0.0, 0.3), [np.arcsin(height / length), 0.0], "DOP853", rtol=1e-12, atol=1e-14,
                      max_step=1e-3, events=lambda time, y: y[0])  # fmt: skip
    start, state = level.t_events[0][0], level.y_events[0][0]
    found = solve_ivp(rate, (start, start + 3e-4), state, "DOP853", rtol=1e-12, atol=1e-15, max_step=1e-6, t_eval=times)
    return stiffness * depth(found.y[0]) ** exponent


def test_force_between_the_steps(drop, evidence):
    steps = np.asarray(drop.history.time)
    pulse = pulses(drop)[0]
    times = np.linspace(pulse.start, pulse.end, 200)
    assert np.sum((steps >= pulse.start) & (steps <= pulse.end)) < 50, "most of these lie between the steps"
    force = np.asarray(at_times(drop, times).contact_force)[:, 0]
    error = float(np.max(np.abs(force - bar_force(times)))) / PEAK
    claim = "force between the steps of a dropped bar's impact, of its peak"
    evidence("Bar drop", claim, error, 5e-4, "SciPy's DOP853 on one equation of the bar")
    assert np.max(force) == pytest.approx(PEAK, rel=1e-3)


def test_instants_at_the_steps_are_the_steps(drop):
    seen = drop.history
    found = at_times(drop, np.asarray(seen.time)[::7])
    np.testing.assert_allclose(found.position, np.asarray(seen.position)[::7], rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.contact_force, np.asarray(seen.contact_force)[::7], rtol=1e-9, atol=1e-9)


def test_a_run_without_history_is_refused(drop):
    bare = jb.simulate(drop.design, drop.scenario, 0.01)
    with pytest.raises(jb.InputError, match="history=True"):
        jb.draw(bare)
    with pytest.raises(jb.InputError, match="history=True"):
        animation.animation(bare)
    with pytest.raises(jb.InputError, match=r"times: 1 s is outside the run, which lasts from 0 to 0\.23 s"):
        jb.draw(drop, times=[1.0])


def test_shapes_move_with_their_bodies():
    frames = np.array([[1.0, 2.0, np.pi / 2.0]])
    square = Outline(0, np.array([[0.0, 0.0], [1.0, 0.0]]))
    np.testing.assert_allclose(outline(square, frames), [[1.0, 2.0], [1.0, 3.0]], atol=1e-15)
    np.testing.assert_allclose(Spot(GROUND, 3.0, 4.0).at(frames), [3.0, 4.0])
    rod = outline(RodShape(Spot(GROUND), Spot(GROUND, 2.0), 0.5), frames)
    np.testing.assert_allclose(rod, [[0.0, -0.25], [2.0, -0.25], [2.0, 0.25], [0.0, 0.25]])
    disc = outline(Disc(Spot(0), 0.5), frames) - [1.0, 2.0]
    np.testing.assert_allclose(np.hypot(*disc.T), 0.5)


def test_a_force_acts_at_the_foot_along_the_normal():
    slope = Segment(0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5), 2.0)  # up to the right; its front is on the left
    touch = Touch(Spot(0), Spot(GROUND), slope, -1.0, 0.1)
    point, normal, tangent = touch.at(np.array([[0.0, 1.0, 0.3]]))
    np.testing.assert_allclose(point, [0.5, 0.5])
    np.testing.assert_allclose(normal, [-np.sqrt(0.5), np.sqrt(0.5)])
    assert abs(float(normal @ tangent)) < 1e-15


@pytest.mark.parametrize("design", [jb.table2(), jb.BarDrop(), jb.SliderCrank()], ids=lambda d: type(d).__name__)
def test_every_mechanism_says_where_its_forces_act(design):
    mechanism = mechanism_of(design)
    names = mechanism.view.names(design)
    drawing = mechanism.view.drawing(design, names.bodies)
    assert isinstance(drawing, Drawing)
    assert isinstance(drawing.detail, Detail)
    assert len(drawing.touches) == len(names.contacts)
    assert len({shape.part for shape in drawing.shapes} - {""}) >= len(names.bodies)


def test_contacts_are_drawn_where_gaps_are_computed(drop):
    """The drawing's own geometry leaves the history's gap between ball and plate."""
    seen, drawing = drop.history, drop.mechanism.view.drawing(drop.design, ())
    frames = drawing.frames(seen)
    (touch,) = drawing.touches
    for k in range(0, len(seen.time), 9):
        point = touch.at(frames[k])[0]
        apart = np.hypot(*(touch.ball.at(frames[k]) - point)) - drop.design.bar.ball_radius
        assert apart == pytest.approx(float(seen.gap[k, 0]), abs=1e-12)


def test_a_mechanism_without_a_drawing_shows_its_bodies():
    assert View.drawing is plain_drawing
    drawing = plain_drawing(jb.BarDrop(), ("bar", "plate"))
    assert [shape.part for shape in drawing.shapes] == ["bar", "", "plate", ""]


def test_motion_figure(drop):
    before = dict(matplotlib.rcParams)
    figure = draw(drop)
    check_readable(figure)
    assert dict(matplotlib.rcParams) == before
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles[0] == "0.0000 s, no contact"
    assert any(title.startswith(f"{AT:.4f} s, 550.2 N") for title in titles)
    for axes in figure.axes:
        assert axes.get_xlabel().endswith(("[m]", "[mm]"))
        assert axes.get_ylabel().endswith(("[m]", "[mm]"))
    assert float(np.min(np.abs(telling_times(drop) - AT))) < 1e-6


def test_frames_are_slow_around_impacts_only(drop):
    times, slower = animation.frames_of(drop)
    assert np.all(np.diff(times) > 0.0)
    assert times[0] == 0.0
    assert times[-1] == float(drop.history.time[-1])
    pulse = pulses(drop)[0]
    inside = (times > pulse.start) & (times < pulse.end)
    assert 10 < inside.sum() < animation.SLOW
    shown = 1.0 / animation.RATE  # s
    np.testing.assert_allclose(np.diff(times)[inside[:-1]] * slower[:-1][inside[:-1]], shown, rtol=1e-6)
    assert animation.speed_in_words(7.63) == "slowed 7.6 times"
    assert animation.speed_in_words(0.5) == "shown 2 times faster"


def test_animation(drop, monkeypatch, tmp_path):
    monkeypatch.setattr(animation, "EVEN", 2)
    monkeypatch.setattr(animation, "SLOW", 3)
    done = []
    content = animation.animation(drop, "gif", lambda k, count: done.append((k, count)))
    film = Image.open(io.BytesIO(content))
    assert film.n_frames == len(done) == done[-1][1] == done[-1][0]
    assert jb.animate(drop, tmp_path / "drop.gif").read_bytes().startswith(b"GIF89a")
    with pytest.raises(jb.InputError, match="format = 'avi'"):
        jb.animate(drop, tmp_path / "drop.avi")


def test_a_pulse_ends_where_its_force_does():
    time = np.linspace(0.0, 1.0, 101)
    force = np.where((time > 0.3) & (time < 0.5), np.sin(np.pi * (time - 0.3) / 0.2), 0.0)
    pulse = pulse_around(time, force, 0.4)
    assert (pulse.start, pulse.end) == (pytest.approx(0.31), pytest.approx(0.49))
    assert pulse.force == pytest.approx(1.0)


def test_a_bending_body_is_drawn_along_its_shape():
    """Half a sine wave between two pins, on a body that is turned by a right angle."""
    bar = pinned_bar(Bar.rectangle(2.0, 0.1, 0.1, 7850.0, 2e11), 1)
    order = Coordinates(1, (bar.modes.size,))
    position = np.array([[[3.0, 4.0, np.pi / 2.0]]])
    history = types.SimpleNamespace(position=position, state=np.array([[3.0, 4.0, np.pi / 2.0, 0.01]]))
    frames = with_stations(position, history, order, bar, 0)[0]
    band = Band(stations(1), 0.1, "bar")
    xi = np.linspace(0.0, 1.0, len(band.stations))
    expected = np.stack([3.0 - 0.01 * np.sin(np.pi * xi), 3.0 + 2.0 * xi], axis=1)
    np.testing.assert_allclose(frames[1:, :2], expected, atol=1e-12)
    np.testing.assert_allclose(frames[1, 2], np.pi / 2.0 + 0.01 * np.pi / 2.0, rtol=1e-9)  # the slope at the pin
    larger = np.stack([3.0 - 0.5 * np.sin(np.pi * xi), 3.0 + 2.0 * xi], axis=1)
    np.testing.assert_allclose(band.bent(frames, 50.0), larger, atol=2e-3)  # stations are apart along the bent line
    straight = with_stations(position, types.SimpleNamespace(state=None), order, bar, 0)[0]
    np.testing.assert_allclose(straight[1:, 0], 3.0, atol=1e-12)
