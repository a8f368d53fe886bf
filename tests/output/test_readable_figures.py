"""Figures of twelve studies, from 20 kg to 8 t, sampled, of many fields and long names: all of them can be read."""

import dataclasses

import jax
import numpy as np
import pytest

import jaxbuffer as jb
from computed import stand_in
from in_short import quick
from jaxbuffer.fields import with_values
from jaxbuffer.mechanisms.probe_cone.bodies import probe_masses
from jaxbuffer.mechanisms.probe_cone.drawing import drawing, mouth
from jaxbuffer.output.envelope_figure import envelope_figure
from jaxbuffer.output.figures import run_figure
from jaxbuffer.output.motion import motion_figure
from jaxbuffer.output.sample_figures import indices_figure, sample_figure, surfaces_figure
from jaxbuffer.output.sweep_figures import sweep_figure
from jaxbuffer.output.tune_figure import front_figure, tune_figure
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.tuning.problem.cases import Distribution, Scatter
from jaxbuffer.tuning.problem.cases import grid as cases_of
from jaxbuffer.tuning.report.front import Front
from made_up import made_up_capture, made_up_sweep, made_up_tuning
from output.drawn import check_readable

# mass, inertia, offset of the hinge or the cone, of both vehicles: what people give, in kg, kg m² and m
VEHICLES = {
    "20 kg": ((20.0, 0.3, 0.1365), (20.0, 0.4, 0.096), {}),
    "350 and 800 kg": ((350.0, 90.0, 0.1365), (800.0, 300.0, 0.096), {}),
    "8 t": ((8000.0, 3e4, 1.8), (8000.0, 4e4, 2.2), {"buffer.k_A": 2e4, "buffer.c_A": 500.0, "probe.length": 0.5}),
}


def design_of(name):
    """The design of `VEHICLES`."""
    (mass, inertia, hinge), (passive_mass, passive_inertia, cone), others = VEHICLES[name]
    values = {"active.mass": mass, "active.inertia": inertia, "active.hinge_offset": hinge, "cone.offset": cone}
    return jb.replace(jb.table2(), values | {"passive.mass": passive_mass, "passive.inertia": passive_inertia} | others)


@pytest.fixture(scope="module")
def captures():
    """A capture of each of `VEHICLES`, by one compiled program, and the figures of each."""
    scenario = jb.Scenario(approach_speed=0.16, misalignment=float(np.radians(1.0)))
    runs = {name: jb.simulate(design_of(name), scenario, 4.0, history=True) for name in VEHICLES}
    return {name: (run, motion_figure(run), run_figure(run)) for name, run in runs.items()}


@pytest.mark.parametrize("name", VEHICLES)
def test_figures_of_a_capture(captures, name):
    _, motion, over_time = captures[name]
    check_readable(motion)
    check_readable(over_time)


@pytest.mark.parametrize("name", VEHICLES)
def test_the_mechanism_is_seen_whatever_its_vehicles(captures, name):
    """The cone's mouth is 0.15 of the picture's height at least, and a vehicle that is broken off says so."""
    run, motion, _ = captures[name]
    axes = motion.axes[0]
    shown = np.diff(axes.get_ylim())[0]
    assert 2.0 * mouth(run.design)[1] > 0.15 * shown
    named = [text.get_text() for text in motion.legends[0].get_texts()]
    assert ("active vehicle, broken off" in named) == (name != "20 kg")
    assert "active vehicle" in named[0] and "hinge with torsional spring and damper" in named


@pytest.mark.parametrize(
    "values",
    [{}, {"active.hinge_offset": 0.0, "cone.offset": 0.0}, {"active.inertia": 1e-3, "passive.inertia": 1e-3},
     {"active.inertia": 1e6, "passive.inertia": 1e6, "active.hinge_offset": 50.0, "cone.offset": 50.0}],
)  # fmt: skip
def test_a_vehicle_has_an_area_and_its_front_where_it_is(values):
    """Neither a line nor larger than nine half-widths of the mouth; the hinge and the throat are at the fronts."""
    design = jb.replace(jb.table2(), values)
    shapes = {shape.part.split(",")[0]: shape for shape in drawing(design).shapes}
    for name, front in (("active vehicle", design.active.hinge_offset), ("passive vehicle", -design.cone.offset)):
        corners = shapes[name].corners
        size = corners.max(axis=0) - corners.min(axis=0)
        assert np.all(size > 0.1 * mouth(design)[1]) and np.all(size < 9.5 * mouth(design)[1])
        ends = corners[:, 0].max() if name == "active vehicle" else corners[:, 0].min()
        assert ends == pytest.approx(front, abs=1e-12)


@pytest.mark.parametrize("name", VEHICLES)
def test_energy_is_drawn_without_the_common_motion(captures, name):
    """At first that is ½ μ v² with the reduced mass (König's theorem) less the turning of the whole, ½ H²/J about the
    common centre of mass, and no prefix makes a number long."""
    run, _, over_time = captures[name]
    (panel,) = (panel for panel in run.mechanism.view.panels(run) if panel.stacked)
    many = {"[kJ]": 1e-3, "[J]": 1.0, "[mJ]": 1e3}[panel.axis.removeprefix("energy ")]
    design = run.design
    active = float(design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass)
    passive = float(design.passive.mass)
    reduced, places = active * passive / (active + passive), np.asarray(run.history.position)
    turning = reduced * 0.16 * places[0, 1, 1]  # the active side passes the other vehicle's centre at this distance
    masses, inertias = (np.array([float(x) for x in numbers]) for numbers in _bodies(design))
    off = places[..., :2] - (masses @ places[..., :2] / masses.sum())[:, None]
    whole = inertias.sum() + np.sum(masses * np.sum(off**2, axis=2), axis=1)
    over = 0.5 * reduced * 0.16**2 - 0.5 * turning**2 / whole  # the farther apart they are, the less turns
    relative = over[0]
    assert panel.curves[0].label == "relative motion"
    assert panel.curves[0].values[0] == pytest.approx(many * relative, rel=1e-9)
    total = sum(np.asarray(curve.values) for curve in panel.curves)
    np.testing.assert_allclose(total, many * over, rtol=1e-6)
    assert 1.0 <= many * relative < 1e3
    (axes,) = (axes for axes in over_time.axes if axes.get_ylabel() == panel.axis)
    assert max(len(text.get_text()) for text in axes.get_yticklabels()) <= 4


def _bodies(design):
    """Masses and inertias of active vehicle, cylinder, probe and passive vehicle."""
    buffer, probe = design.buffer, probe_masses(design)
    cylinder = buffer.cylinder_mass * buffer.cylinder_length**2 / 12
    masses = (design.active.mass, buffer.cylinder_mass, probe.mass, design.passive.mass)
    return masses, (design.active.inertia, cylinder, probe.inertia, design.passive.inertia)


def test_a_force_is_drawn_smoothly(captures):
    """Every listed impact has 20 points of its curve at least, and the curve reaches the peak."""
    run, _, over_time = captures["350 and 800 kg"]
    lower = over_time.axes[0].lines[0]
    time, force = lower.get_xdata(), lower.get_ydata()  # s, N
    hits = run.impacts
    assert int(hits.count) > 5
    for k in range(5):
        inside = (time >= float(hits.time[k])) & (time <= float(hits.release_time[k]))
        assert np.sum(inside) >= 20
        assert np.max(force[inside]) == pytest.approx(float(hits.peak_force[k]), rel=0.01)
    assert np.max(force) == pytest.approx(float(run.peak_force), rel=1e-4)


def test_figure_of_a_capture_with_every_part():
    """End stop, play and bending add panels and parts of the energy."""
    values = {"buffer.stop_stiffness": 1e5, "hinge.play": 1e-4, "probe.bending_stiffness": 300.0}
    run = made_up_capture(design=jb.replace(jb.table2(), values), peak=43210.0)
    still = 0.0 * run.history.time
    stored = {**run.energy.stored, "hinge": 0.0}, {**run.history.energy.stored, "hinge": still}
    others = {**run.history.others, "bending": still, "hinge_gap": still}
    energy = dataclasses.replace(run.history.energy, stored=stored[1])
    history = dataclasses.replace(run.history, energy=energy, others=others)
    check_readable(run_figure(dataclasses.replace(run, history=history)))


def problem(cases, variables=("buffer.k_A",), design=None, **options):
    """A design problem with a variable or several, around the design's own values."""
    design = design or jb.table2()
    bounds = [jb.Variable(path, 0.5 * jb.get(design, path), 3.0 * jb.get(design, path)) for path in variables]
    return jb.Problem(design, cases, bounds, **options)


def sampled(count):
    """Cases that differ in six numbers."""
    spread = {path: Distribution("uniform", 0.9, 1.1) for path in ("buffer.k_A", "buffer.c_A", "probe.tip_mass")}
    speeds = {
        "approach_speed": Distribution("uniform", 0.08, 0.16),
        "misalignment": Distribution("uniform", -0.02, 0.02),
        "passive_rate": Distribution("uniform", -0.01, 0.01),
    }
    return Scatter(count, speeds, spread).cases([jb.Case(jb.Scenario())], jb.table2())


MANY = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "buffer.free_length", "buffer.cylinder_mass",
        "buffer.cylinder_length", "probe.tip_mass", "probe.tip_radius", "probe.rod_mass", "active.hinge_offset",
        "contact.young_modulus")  # fmt: skip
WORK = jb.CustomQuantity(lambda peak_force, stroke: peak_force * stroke, "N m")
LONG = "the_work_that_a_spring_as_stiff_as_the_peak_would_take_up_in_the_whole_stroke"
PROBLEMS = {
    "a grid": lambda: problem(cases_of({"approach_speed": [0.08, 0.12, 0.16], "misalignment": [-0.02, 0.02]})),
    "a sample of 24": lambda: problem(sampled(24), limits=jb.Limits(at_most={"stroke": 0.1})),
    "a sample of 100": lambda: problem(sampled(100), design=design_of("8 t")),
    "in space": lambda: problem(
        [
            jb.Case(jb.Scenario3D(approach_speed=speed, passive_pitch=0.01, azimuth=azimuth))
            for speed in (0.08, 0.12)
            for azimuth in (0.0, 2.0)
        ],
        design=jb.docking3d(),
    ),
    "many variables": lambda: problem([jb.Scenario()], MANY),
    "long names": lambda: problem(
        cases_of({"approach_speed": [0.1, 0.2], "contact_distance": [0.03, 0.0435], "passive_rate": [0.0, 0.02]}),
        objective=jb.Objective({"peak_force": 1.0, LONG: 0.1}),
        limits=jb.Limits(at_most={LONG: 5.0, "peak_hinge_force": 240.0}),
        quantities={LONG: WORK},
    ),
}


@pytest.mark.parametrize("name", quick(PROBLEMS, "a sample of 24", "in space", "long names"))
def test_figure_of_a_tuning(name):
    tuned = made_up_tuning(PROBLEMS[name]())
    worst = [made_up_capture(peak=400.0), made_up_capture(peak=320.0)]
    check_readable(tune_figure(tuned, worst))


SWEEPS = {
    "five fields": {
        "scenario.approach_speed": [0.1, 0.15, 0.2],
        "scenario.misalignment": [-0.05, 0.0, 0.05],
        "buffer.k_A": [300.0, 500.0, 1000.0],
        "buffer.cylinder_length": [0.12, 0.13],
        "probe.tip_mass": [0.03, 0.1],
    },
    "speeds by laws": {
        "scenario.approach_speed": [0.1, 0.15, 0.2],
        "contact.law": ["hertz", "lankarani-nikravesh", "hunt-crossley", "flores"],
        "buffer.damping": ["physical", "published"],
    },
    "two fields by laws": {
        "scenario.approach_speed": [0.1, 0.15, 0.2],
        "buffer.k_A": [100.0, 300.0, 1000.0],
        "contact.law": ["hertz", "lankarani-nikravesh"],
        "buffer.damping": ["physical", "published"],
    },
}


def swept(asked, outcomes=None):
    """A made-up sweep."""
    design, scenario = jb.table2(), jb.Scenario()
    over = grid(asked, design, scenario)
    numbers = {path: np.asarray(values) for path, values in over.columns().items() if not isinstance(values[0], str)}
    found = made_up_sweep(*with_values(design, scenario, numbers), outcomes)
    return dataclasses.replace(found, design=design, scenarios=scenario, grid=over)


@pytest.mark.parametrize("name", quick(SWEEPS, "speeds by laws"))
def test_figure_of_a_sweep(name):
    failed = {1: jb.Outcome.escaped, 2: jb.Outcome.timeout, 3: jb.Outcome.failed_not_finite, 4: jb.Outcome.bottomed}
    figure = sweep_figure(swept(SWEEPS[name], failed))
    check_readable(figure)
    for bar in (axes for axes in figure.axes if axes.get_label() == "<colorbar>"):
        assert len(bar.get_yticks()) > 3, "no label is left out where there is room"


def test_figures_have_the_units_that_were_typed():
    asked = {
        "scenario.contact_distance": ["30 mm", "40 mm", "50 mm"],
        "scenario.misalignment": ["-2 deg", "0 deg", "3 deg"],
    }
    sweep, limits = swept(asked), jb.Limits(at_most={"peak_force": 250.0})
    for axes in (envelope_figure(jb.safe_rectangle(sweep, limits)).axes[0], sweep_figure(sweep).axes[0]):
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("contact distance [mm]", "misalignment [°]")
        assert 20.0 < axes.get_xlim()[0] < axes.get_xlim()[1] < 60.0 and -5.0 < axes.get_ylim()[0] < -2.0


@pytest.mark.slow
def test_figures_of_an_envelope_and_a_sample(monkeypatch):
    limits = jb.Limits(at_most={"peak_force": 250.0, "peak_hinge_force": 240.0, "hinge_angle": 0.004, "stroke": 0.009})
    asked = {"scenario.contact_distance": [0.03, 0.04, 0.05], "scenario.approach_speed": [0.1, 0.15, 0.2, 0.25]}
    check_readable(envelope_figure(jb.safe_rectangle(swept(asked, {1: jb.Outcome.escaped}), limits)))
    stand_in(monkeypatch)
    over = {"buffer.cylinder_length": (0.1, 0.14), "contact.young_modulus": (60e9, 80e9, "log"),
            "probe.tip_mass": (0.03, 0.1), "scenario.approach_speed": (0.05, 0.3),
            "scenario.contact_distance": (0.03, 0.05), "buffer.k_A": (100.0, 2000.0)}  # fmt: skip
    made = jb.sample(jb.table2(), jb.Scenario(), over, 32, "saltelli", progress=lambda *_: None)
    check_readable(sample_figure(made))
    check_readable(indices_figure(jb.sobol_indices(made, ["peak_force", "peak_hinge_force"])))
    surfaces = [jb.response_surface(made, name, "quadratic") for name in ("peak_force", "peak_hinge_force")]
    check_readable(surfaces_figure(surfaces))


def test_a_front_marks_what_did_not_converge():
    """Two points near each other share a text, and the hollow mark is at the one that did not converge."""
    objectives = ("peak_force", "stroke", "peak_hinge_force", "hinge_angle", "end_time")
    base = made_up_tuning(problem([jb.Scenario()]))
    columns = [base.problem.names.index(name) for name in objectives]
    points = []
    for k, share in enumerate((0.0, 0.02, 0.5, 1.0)):
        after = jax.tree.map(np.array, base.after)
        after.peaks[:, 0] *= 1.0 + share
        after.rest[:, [c - 1 for c in columns[1:]]] *= 2.0 - share
        points.append(dataclasses.replace(base, after=after, ended="converged" if k != 2 else "stalled"))
    front = Front(base.problem, objectives, np.full((4, 4), np.inf), tuple(points))
    figure = front_figure(front)
    check_readable(figure)
    for axes in figure.axes:
        (hollow,) = (line for line in axes.lines if line.get_label() == "front, not converged")
        assert hollow.get_ydata() == pytest.approx([front.values[2, 0]])
        assert [text.get_text() for text in axes.texts] == ["4", "3", "2, 1"]
