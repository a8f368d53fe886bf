"""The tables of a choice: each number once, and load cases by their numbers."""

import jaxbuffer as jb
from jaxbuffer.choosing.choice import _ranking, lines
from made_up_choice import made_up_choice


def headings_of(choice):
    return [str(column.header) for column in _ranking(choice).columns]


def test_a_price_that_orders_has_one_column():
    priced = made_up_choice(then=jb.SecondObjective(jb.Objective({"price": 1.0}), tolerance=0.2))
    assert [it for it in headings_of(priced) if "EUR" in it] == ["price [EUR]"]
    of_runs = made_up_choice(then=jb.SecondObjective(jb.Objective({"stroke": 1.0}), tolerance=0.2))
    assert "then [mm]" in headings_of(of_runs)


def test_a_ranking_has_the_numbers_of_load_cases_which_a_line_says():
    choice = made_up_choice()
    (column,) = (it for it in _ranking(choice).columns if it.header == "largest at")
    assert [*column.cells] == ["2.4", "2.4"]
    said = [line for line in lines(choice) if line.startswith("largest at")]
    assert said == ["largest at 2.4: 0.14 m/s, 0°, 1.2 buffer.c_A, probe.tip_radius +0.5 mm"]
