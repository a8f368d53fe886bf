"""Measured tests with an offset, spikes, clipped rows or a wrong unit: the true numbers, or a word and no green."""

import json
from pathlib import Path

import pytest

import jaxbuffer as jb
from fitting.test_measured import ACTIVE, PASSIVE, PATHS, SOURCE, STROKE

FOLDER = Path(__file__).with_name("damaged")
OFFSETS = ({"offset": ("-2 mm", "2 mm")}, {"offset": ("-0.6 m/s^2", "0.6 m/s^2")})


def damaged(name, stroke=STROKE, offsets=({}, {})):
    told = json.loads((FOLDER / f"{name}.json").read_text())
    design = jb.replace(jb.table2(), {path: told["start"][key] for key, (path, _) in PATHS.items()})
    scenario = jb.Scenario(**{key: told["known"][key] for key in ("approach_speed", "misalignment")})
    channels = {
        stroke: jb.Channel("stroke", noise=f"{told['noise']['stroke']} m", **offsets[0]),
        ACTIVE: jb.Channel("active_acceleration_x", noise=told["noise"]["active"], **offsets[1]),
        PASSIVE: jb.Channel("passive_acceleration_x", noise=told["noise"]["passive"], **offsets[1]),
    }
    shift = ("0 ms", "30 ms") if told["kind"] == "late trigger" else 0.0
    units = jb.recorded_quantities(design)
    test = jb.read_recording(FOLDER / f"{name}.csv", channels, scenario=scenario, time_shift=shift, units=units)
    return told, jb.fit(design, None, test, dict(PATHS.values()))


def check(fit, told, evidence, percent=1.0, deviations=6.0):
    """Each number is as near to the true one as some per cent, or some deviations of what noise allows."""
    assert fit.converged and fit.explained
    worst = max(
        100.0 * abs(fit.parameters[path].value / told["truth"][key] - 1.0)
        / max(percent, deviations * told["cramer_rao_percent"][key])
        for key, (path, _) in PATHS.items()
    )  # fmt: skip
    kind = told["damage"]["kind"]
    claim = f"{kind}: error of the worst number over {percent:g} % or {deviations:g} Cramér-Rao deviations"
    evidence("fit to a damaged test", claim, worst, 1.0, SOURCE)


@pytest.mark.long
def test_unknown_offsets_are_found_beside_the_numbers(evidence):
    told, fit = damaged("offset-00", offsets=OFFSETS)
    check(fit, told, evidence)
    own, truth = fit.nuisance["offset-00.csv"], told["damage"]["offset"]
    for column, true in (
        (STROKE, 1e-3 * truth["stroke_mm"]),
        (ACTIVE, truth["active"]),
        (PASSIVE, truth["passive"]),
    ):
        it = own[f"{column}: offset"]
        # Four deviations, of which the interval has 3.92.
        assert abs(it.value - true) < 4.0 * (it.high - it.low) / 3.92
    assert own[f"{STROKE}: offset"].unit == "m" and own[f"{ACTIVE}: offset"].unit == "m/s²"


@pytest.mark.long
def test_spikes_are_listed_and_do_not_move_the_numbers(evidence):
    told, fit = damaged("spikes-01")
    check(fit, told, evidence)
    # A row of the damage is two lines further down: lines count from one, and the first has the headings.
    for k, column in ((1, STROKE), (2, ACTIVE), (3, PASSIVE)):
        assert set(fit.outliers["spikes-01.csv"][column]) == {row + 2 for row in told["damage"]["rows"][str(k)]}
        assert fit.residual["spikes-01.csv"][column] < 1.05
    assert f"{ACTIVE}: 16 rows stick out by more than five deviations" in repr(fit).replace("\n", " ")
    assert not fit.clipped


@pytest.mark.long
def test_clipped_rows_are_left_out_and_said(evidence):
    told, fit = damaged("clipped-00")
    check(fit, told, evidence, percent=2.0, deviations=12.0)
    counts = {column: len(rows) for column, rows in fit.clipped["clipped-00.csv"].items()}
    # Counted in the file: rows at ±0.352264 and at 1.8862 m/s².
    assert counts == {ACTIVE: 3, PASSIVE: 5}
    assert f"{PASSIVE}: 5 rows have the column's extreme value: clipped" in repr(fit).replace("\n", " ")


@pytest.mark.long
def test_a_column_in_another_unit_is_named_and_nothing_is_called_sure():
    _, fit = damaged("unit-00", "stroke [cm]")
    assert not fit.explained and "95 %" not in repr(fit) and "NOT explained" in repr(fit)
    (line,) = fit.doubtful
    assert 'unit-00.csv: column "stroke [cm]": unit or sign?' in line and "Times 0.1" in line and line in repr(fit)
