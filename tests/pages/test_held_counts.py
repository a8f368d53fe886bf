"""What pages, sweeps and envelopes say of runs that are held, of runs that are not there, and of limits on nothing."""

import dataclasses
import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.experiments.rectangle import UNDONE
from jaxbuffer.fields import paths
from jaxbuffer.files import write
from jaxbuffer.output.folder import load
from jaxbuffer.output.swept_files import swept_files
from jaxbuffer.output.tuned_files import tuned_files
from jaxbuffer.pages.abstract import _ended, _strictest
from jaxbuffer.pages.compare import compared, comparison
from jaxbuffer.pages.designs import _scenarios, requirements
from jaxbuffer.pages.limit_check import limit_check
from jaxbuffer.pages.review import review
from jaxbuffer.sweeps.grid import grid
from made_up import made_up_evaluation, made_up_sweep, made_up_tuning

LATCH = {"latch.stiffness": 2e3, "latch.damping": 50.0}  # N/m, N s/m
SPEEDS = [0.05, 0.1, 0.15, 0.2]  # m/s


def folder_of(place, after, limits, relative_energy=0.001, corners=None):
    """Results of a made-up tuning of a design with latches, each of whose runs ends ``after`` with an outcome."""
    design = jb.replace(jb.table2(), LATCH)
    scenarios = [jb.Scenario(approach_speed=speed) for speed in SPEEDS]
    stated = jb.Problem(design, scenarios, [jb.Variable("buffer.k_A", 100.0, 2000.0)], limits=limits)

    def ended(outcomes):
        point = made_up_evaluation(stated, stated.start())
        rest, code = point.rest.copy(), np.array([int(jb.Outcome[name]) for name in outcomes])
        rest[:, stated.names.index("relative_energy") - 1] = relative_energy
        return point._replace(rest=rest, code=code, succeeded=stated.succeeded(code))

    tuned = dataclasses.replace(made_up_tuning(stated), before=ended(["held"] * 4), after=ended(after), corners=corners)
    place.mkdir(exist_ok=True)
    for name, content in tuned_files(tuned).items():
        if name in ("tuned.json", "design.toml"):
            write(place / name, content())
    return load(place)


def badges(page):
    return {badge.text: badge.mark for badge in page.verdicts}


def test_all_limits_kept_does_not_stand_alone_where_nothing_is_held(tmp_path):
    results = folder_of(tmp_path, ["latched"] * 4, jb.Limits(at_most={"stroke": 0.025}))
    page = review([results])
    assert badges(page)["all limits kept, held in 0 of 4"] == "unsure"
    assert "keeps every limit in the 4 scenarios, held in 0 of 4" in page.abstract[0]
    assert "eld is not asked for: 0 of 4 are held, 4 before" in page.html()


def test_held_that_is_asked_for_is_judged_by_page_and_record_alike(tmp_path):
    limits = jb.Limits(held=True, at_most={"relative_energy": 0.001})
    results = folder_of(tmp_path, ["held"] * 3 + ["latched"], limits)
    assert not results.tuned["feasible"] and any("not held" in line for line in results.tuned["broken"])
    check = limit_check(results)
    assert check.success == "held" and check.missed == [3] and check.keeping == [True, True, True, False]
    found = badges(review([results]))
    assert found["1 of 4 not held, held in 3 of 4"] == "bad"
    kept = folder_of(tmp_path / "kept", ["held"] * 4, limits, 0.001 * (1.0 + 1e-14))
    (text,) = (text for text in badges(review([kept])) if "limits kept" in text)
    assert kept.tuned["feasible"] and text == "all limits kept, 1 at the limit, held in 4 of 4"


def test_a_table_tells_a_value_from_the_limit_that_it_breaks(tmp_path):
    """0.10002 % over a limit of 0.1 %: both would be 0.1 to four digits."""
    results = folder_of(tmp_path, ["held"] * 4, jb.Limits(at_most={"relative_energy": 0.001}), 0.0010002)
    page = review([results])
    (section,) = (part for part in page.sections if part.title == "Limits")
    (row,) = (row for row in section.tables[0].rows if row[0] == "relative energy left")
    assert (row[2], row[4]) == ("0.1000", "≤ 0.1") or float(row[2]) > 0.1
    assert "relative energy left in 4" in section.warnings[0]
    assert any("broken in 4 of 4 scenarios" in line for line in results.tuned["broken_limits"])


def test_what_stands_in_the_way_comes_first_on_the_page_too(tmp_path):
    """Hinge angles of 4 mrad leave 9 % of 4.4 mrad, strokes of 10 mm 60 % of 25 mm; 0.1 % of the energy is above
    0.09 %."""
    limits = jb.Limits(held=True, at_most={"stroke": 0.025, "hinge_angle": 0.0044, "relative_energy": 0.0009})

    def names(place, after):
        page = review([folder_of(place, after, limits)])
        (section,) = (part for part in page.sections if part.title == "Limits")
        return [row[0] for row in section.tables[0].rows]

    shares = ["hinge angle", "buffer stroke"]  # 4 of 4.4 mrad, 10 of 25 mm
    found = names(tmp_path / "held", ["held"] * 4)
    assert found[0] == "relative energy left" and [it for it in found if it in shares] == shares and found[-1] == "held"
    assert names(tmp_path / "latched", ["held"] * 3 + ["latched"])[:2] == ["held", "relative energy left"]


def test_compared_tunings_say_how_many_are_held(tmp_path):
    limits = jb.Limits(at_most={"stroke": 0.025})
    every = [folder_of(tmp_path / name, [name] * 4, limits) for name in ("held", "latched")]
    (table,) = (table for table in compared(every) if table.caption == "How many scenarios end so")
    assert [cell.text for cell in table.rows[1][1:]] == ["held in 4 of 4", "held in 0 of 4"]
    texts = badges(comparison(every))
    assert any(text.endswith("all limits kept, held in 0 of 4") for text in texts)


def test_a_sweep_says_how_many_are_held_and_how_many_run():
    design, scenario = jb.replace(jb.table2(), LATCH), jb.Scenario()
    over = grid({"scenario.approach_speed": SPEEDS}, design, scenario)
    codes = dict(enumerate([int(jb.Outcome.held), int(jb.Outcome.latched), int(jb.Outcome.held), -1]))
    swept = dataclasses.replace(
        made_up_sweep(*over.applied(design, scenario), outcomes=codes), design=design, scenarios=scenario, grid=over
    )
    text = " ".join(repr(swept).split())
    assert "interrupted, 3 of them done; held in 2 of 3" in text
    one_by_one = " ".join(repr(dataclasses.replace(swept, grid=None)).split())
    assert "interrupted, 3 of them done" in one_by_one


def interrupted(done, limits, design=None):
    """A sweep of 4 speeds at 3 misalignments of which the first ``done`` runs were made, and what is safe in it."""
    design, scenario = design or jb.table2(), jb.Scenario()
    over = grid({"scenario.approach_speed": SPEEDS, "scenario.misalignment": [0.0, 0.01, 0.02]}, design, scenario)
    swept = made_up_sweep(*over.applied(design, scenario), outcomes={k: -1 for k in range(done, 12)})
    swept = dataclasses.replace(swept, design=design, scenarios=scenario, grid=over)
    met = [jb.Scenario(approach_speed=0.05), jb.Scenario(approach_speed=0.2, misalignment=0.02)]
    return swept, jb.safe_rectangle(swept, limits, met)


@pytest.mark.parametrize(("done", "said"), [(7, "7 of 12 captures run"), (12, "all 12 captures are safe")])
def test_nothing_is_said_to_be_safe_over_runs_that_are_not_there(tmp_path, done, said):
    swept, envelope = interrupted(done, jb.Limits(at_most={"peak_force": 1000.0}))
    between = envelope.between
    assert (between.runs, between.total, between.unsafe) == (done, 12, 0) and said in between.words
    assert ("safe" in between.words.replace("unsafe", "")) == (done == 12)
    assert (envelope.reasons == UNDONE).sum() == 12 - done and envelope.runs <= done
    record = json.loads(swept_files(swept, envelope=envelope)["sweep.json"]())["envelope"]
    assert (record["done"], record["safe_runs"], record["runs"]) == (done, done, 12)
    for name, content in swept_files(swept, envelope=envelope).items():
        if name in ("sweep.nc", "sweep.json"):
            write(tmp_path / name, content())
    page = review([load(tmp_path)])
    counted = "12 of 12 runs" if done == 12 else "7 of 7 computed runs, of 12 asked for,"
    assert badges(page)[f"{counted} of the sweep are safe"] == ("good" if done == 12 else "unsure")
    assert f"{counted.removesuffix(' runs')} keep every limit" in " ".join(page.abstract)
    (section,) = (part for part in page.sections if part.title == "Envelope")
    assert between.words in (section.text if done == 12 else section.warnings)


def test_a_limit_on_what_the_design_has_not_is_no_safe_rectangle():
    with pytest.raises(jb.InputError) as caught:
        interrupted(12, jb.Limits(at_most={"peak_stop_force": 10.0}))
    assert "peak_stop_force needs buffer.stop_stiffness, which the design has not" in str(caught.value)


def test_a_run_whose_limited_quantity_is_not_known_is_not_safe():
    """No made-up run settles: all are captured, none is held, and none has a settling time."""
    _, envelope = interrupted(12, jb.Limits(at_most={"settling_time": 5.0}), jb.replace(jb.table2(), LATCH))
    assert not envelope.safe.any() and envelope.criterion.startswith("held")
    stop = jb.replace(jb.table2(), {"buffer.stop_stiffness": 1e5})
    swept, _ = interrupted(12, jb.Limits(), stop)
    columns = {**swept.columns, "peak_stop_force": np.full(12, np.nan)}
    unknown = jb.safe_rectangle(
        dataclasses.replace(swept, columns=columns), jb.Limits(at_most={"peak_stop_force": 1.0})
    )
    assert set(unknown.reasons.ravel()) == {"peak stop force not known"} and not unknown.safe.any()


@pytest.mark.parametrize(
    ("counts", "said"),
    [
        ({"held": 35, "timed_out": 14}, "35 of 49 captures end held in a sweep"),
        (
            {"held": 20, "latched": 15, "timed_out": 14},
            "35 of 49 captures end held or latched in a sweep, held in 20 of 49",
        ),
        ({"timed_out": 49}, "0 of 49 captures end captured in a sweep, held in 0 of 49"),
    ],
)
def test_one_count_is_said_once(tmp_path, counts, said):
    results = folder_of(tmp_path, ["held"] * 4, jb.Limits())
    assert f"{_ended(results.mechanism, counts)} in a sweep{_strictest(results, counts)}" == said


def test_what_is_left_out_and_asked_fits_design_and_start(tmp_path):
    """Of a design with latches what comes after capture is simulated; a free start has no contact distance."""
    latched, free = folder_of(tmp_path, ["held"] * 4, jb.Limits()), jb.Scenario(start="free", offset=0.01)
    mechanism = latched.mechanism
    (text,) = requirements(latched, [latched]).text
    assert "motion is planar" in text and "not simulated" not in text
    plain = mechanism.view.left_out(lambda path: jb.get(jb.table2(), path))
    assert any("what the parts do afterwards is not simulated" in line for line in plain)

    def asked(*scenarios):
        records = [{path: getattr(it, path) for path in paths(it)} for it in scenarios]
        return {row[1] for row in _scenarios(mechanism, records, {})}

    of_contact = {row[1] for row in requirements(latched, [latched]).tables[0].rows}
    assert "contact distance" in of_contact and "offset" not in of_contact
    assert "offset" in asked(free) and "contact distance" not in asked(free)
    assert {"offset", "contact distance"} <= asked(free, jb.Scenario())
    met = [free, jb.Scenario(), jb.Scenario(contact_distance=0.05)]
    labels = [mechanism.view.label(it, met) for it in met]
    assert ["contact distance" in it for it in labels] == [False, True, True]
