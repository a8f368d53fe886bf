"""Catalogues of parts: what is read, and what is said of one that is wrong."""

import re

import pytest

from jaxbuffer import InputError, table2
from jaxbuffer.choosing.catalogue import read_catalogues
from jaxbuffer.choosing.combinations import Combinations

CSV = """\
# the dealer's list
name,k_A [kN/m],max_stroke [mm],price [EUR],mass [g]
S1,0.5,25,11,40

S2,1.5,20,17,55
"""


def read(given, folder=None):
    return read_catalogues(given, table2(), **({} if folder is None else {"folder": folder}))


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_csv_file_and_a_table_say_the_same(tmp_path, delimiter):
    (tmp_path / "springs.csv").write_text(CSV.replace(",", delimiter))
    rows = {
        "S1": {"k_A": "0.5 kN/m", "buffer.max_stroke": "25 mm", "price": "11 EUR", "mass": "40 g"},
        "S2": {"buffer": {"k_A": "1500 N/m", "max_stroke": "2 cm"}, "price": "17 EUR", "mass": "55 g"},
    }
    (of_file,) = read({"spring": {"file": "springs.csv"}}, tmp_path)
    (of_table,) = read({"spring": rows})
    assert [part.name for part in of_file.parts] == ["S1", "S2"]
    for one, other in zip(of_file.parts, of_table.parts, strict=True):
        assert one.fields == pytest.approx(other.fields) and one.totals == pytest.approx(other.totals)
    assert of_file.parts[1].fields == {"buffer.k_A": 1500.0, "buffer.max_stroke": 0.02}
    assert of_file.price_unit == "EUR" and of_file.units["buffer.k_A"] == "kN/m"


def test_a_curve_stands_for_the_number_that_other_parts_set():
    parts = {"D1": {"c_A": 12.0}, "D2": {"damper_curve": [[0.1, 1.0], [0.2, 4.0]]}}
    combinations = Combinations(table2(), read({"damper": parts}))
    assert combinations.built(0).buffer.c_A == 12.0 and combinations.built(0).buffer.damper_curve is None
    assert combinations.built(1).buffer.c_A is None
    assert combinations.built(1).buffer.damper_curve.points() == [[0.1, 1.0], [0.2, 4.0]]


def test_every_combination_is_built_once_with_its_sums():
    springs = {f"S{k}": {"k_A": 100.0 * k, "price": k, "mass": 0.1 * k} for k in (1, 2, 3)}
    tips = {f"T{k}": {"tip_mass": 0.01 * k, "price": 10 * k} for k in (1, 2)}
    combinations = Combinations(table2(), read({"spring": springs, "tip": tips}))
    assert [combinations.names(k) for k in (0, 1, 5)] == [("S1", "T1"), ("S1", "T2"), ("S3", "T2")]
    assert combinations.totals("price").tolist() == [11.0, 21.0, 12.0, 22.0, 13.0, 23.0]
    assert combinations.totals("mass") == pytest.approx([0.1, 0.1, 0.2, 0.2, 0.3, 0.3]), "a tip without one adds none"
    design = combinations.built(combinations.number((2, 1)))
    assert (design.buffer.k_A, design.probe.tip_mass) == (300.0, 0.02)


def test_parts_that_do_not_go_together_are_told():
    parts = {"spring": {"S1": {"free_length": "20 mm"}}, "stop": {"E1": {"max_stroke": "30 mm"}}}
    why = Combinations(table2(), read({**parts})).built(0)
    assert isinstance(why, InputError) and "buffer.max_stroke" in str(why)


S1, S2 = {"k_A": 500.0}, {"k_A": 700.0}
BAD = [
    ({}, "parts = {}; write [parts.spring]"),
    ({"spring": {}}, "parts.spring has no part"),
    ({"spring": 5}, "parts.spring = 5; write"),
    ({"spring": {"S1": 500.0}}, "parts.spring.S1 = 500.0 is no part"),
    ({"spring": {"S1": {"k_a": 500.0}}}, "parts.spring.S1.k_a: k_a is unknown; did you mean buffer.k_A?"),
    ({"spring": {"S1": {"k_A": "500 N"}}}, "parts.spring.S1.k_A = '500 N': N is a force, expected a number in N/m"),
    ({"spring": {"S1": {"k_A": -5.0}}}, "parts.spring.S1.k_A = -5 N/m is out of range"),
    ({"spring": {"S1": {"k_A": float("nan")}}}, "parts.spring.S1.k_A = nan"),
    ({"spring": {"S1": S1, "S2": {"c_A": 3.0}}}, "parts.spring.S2 has no buffer.k_A, which S1 has"),
    ({"spring": {"S1": S1, "S2": S2 | {"price": 3}}}, "parts.spring.S1 has no price, which S2 has"),
    ({"spring": {"S1": S1}, "other": {"X": S2}}, "parts.spring and parts.other both set buffer.k_A; keep one"),
    (
        {"spring": {"S1": S1 | {"price": "3 EUR"}}, "tip": {"T": {"tip_mass": 0.1, "price": "3 USD"}}},
        "parts.spring has prices in EUR and parts.tip in USD",
    ),
    ({"spring": {"S1": S1 | {"price": "3 EUR"}, "S2": S2 | {"price": "3 USD"}}}, "prices in EUR and USD; keep one"),
    ({"spring": {"S1": {"k_A": "500 N/m"}, "S2": S2}}, "700 has no unit"),
    ({"spring": {"S1": {"price": 3}}}, "parts.spring.S1 sets no field of the design"),
    ({"spring": {"S1": S1 | {"price": "cheap"}}}, "is no price"),
    ({"spring": {"S1": S1 | {"price": "9,50 EUR"}}}, "is no price; write 12.5"),
    ({"spring": {"S1": S1 | {"price": "1 200 EUR"}}}, "is no price"),
    ({"spring": {"S1": S1 | {"price": "1.200.000 EUR"}}}, "is no price"),
    ({"spring": {"S1": S1 | {"price": float("nan")}}}, "parts.spring.S1.price = nan"),
    ({"spring": {"S1": S1 | {"buffer.k_A": 400.0}}}, "S1 sets buffer.k_A twice"),
    ({"contact": {"X": {"young_modulus": 7e10}}}, "young_modulus may be"),
    ({"contact": {"X": {"law": "herz"}}}, "parts.contact.X.law: contact.law = 'herz'"),
]


@pytest.mark.parametrize(("given", "message"), BAD, ids=[message for _, message in BAD])
def test_what_is_wrong_with_a_table_is_said(given, message):
    with pytest.raises(InputError, match=re.escape(message)):
        read(given)


BAD_FILES = [
    ("name,k_A [N/m]\nS1,500\nS2,600\nS1,700\n", "springs.csv, line 4: S1 stands in line 2 already; keep one"),
    ("# list\n\nname,k_A\nS1,500,3\n", "springs.csv, line 4 has 3 cells, and line 3 names 2 columns"),
    ("k_A [N/m]\n500\n", "springs.csv, line 1: no column is called name; found k_A [N/m]"),
    ("name,k_A,k_A\nS1,5,6\n", "springs.csv, line 1: k_A is the heading of two columns"),
    ("name,,k_A\nS1,5,6\n", "springs.csv, line 1: column 2 has no heading"),
    ("name,k_A [N/m]\n,500\n", "springs.csv, line 2: the part has no name"),
    ("name,k_A [kN/m]\nS1,500 N/m\n", "springs.csv, line 2, k_A = '500 N/m': the heading has the unit kN/m already"),
    ("name,k_A [N/m]\nS1,nan\n", "springs.csv, line 2, k_A = nan"),
    ("name,k_A [N/m],c_A\nS1,500,3\nS2,600,\n", "parts.spring.S2 has no buffer.c_A, which S1 has"),
    ("name,k_B [N/m]\nS1,500\n", "springs.csv, line 2, k_B: k_B is unknown; did you mean buffer.k_A"),
    ("name,k_A [N]\nS1,500\n", "springs.csv, line 2, k_A = '500 N': N is a force"),
    ("name,k_A [N/m]\nS1,soft\n", "springs.csv, line 2, k_A"),
    ('name,damper_curve\nD1,"[[0.1, 2.0]"\n', "springs.csv, line 2, damper_curve = '[[0.1, 2.0]' is no list of points"),
    ("name;k_A\nS1;0,5\nS2;0.6\n", 'springs.csv, line 3, column "k_A": 0.6 beside line 2, column "k_A": 0,5'),
    ("name;price\nS1;9,50 EUR\nS2;1.200 EUR\n", 'line 3, column "price": 1.200 EUR beside line 2'),
    ('name,k_A\nS1,"0,5"\n', "0,5 beside commas between the cells: a file has one decimal mark"),
    ("name,k_A [N/m]\nS1,0,5\n", "3 cells, and line 1 names 2 columns; numbers with decimal commas need semicolons"),
    ("name;k_A [N/m]\nS1;1.194,5\n", "line 2, k_A = '1.194,5' is no number: a file has one decimal mark"),
    ("# name, k_A [N/m]\nS1,500\nS2,600\n", "no column is called name; line 1 has it behind a #"),
    ("", "springs.csv has no part"),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES, ids=[message for _, message in BAD_FILES])
def test_what_is_wrong_with_a_file_is_said_with_its_line(tmp_path, text, message):
    (tmp_path / "springs.csv").write_text(text)
    with pytest.raises(InputError, match=re.escape(message)):
        read({"spring": {"file": "springs.csv"}}, tmp_path)


def test_a_file_that_is_missing_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.csv: no such file"):
        read({"spring": "none.csv"}, tmp_path)


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas_are_read_as_of_measured_tests(tmp_path, delimiter):
    """Beside whole numbers, names and curves with points of their own, of a unit in the heading or in the cell."""
    rows = (
        ("name", "k_A [kN/m]", "price", "damper_curve"),
        ("4.7", "0,5", "9,50 EUR", "[[0.1, 2.0], [0.2, 5.0]]"),
        ("4,8", "1", "11 EUR", "[[0.1, 3.0], [0.2, 6.5]]"),
    )
    (tmp_path / "springs.csv").write_text("\n".join(delimiter.join(row) for row in rows))
    (made,) = read({"spring": "springs.csv"}, tmp_path)
    assert [(part.name, part.fields["buffer.k_A"], part.totals["price"]) for part in made.parts] == [
        ("4.7", 500.0, 9.5),
        ("4,8", 1000.0, 11.0),
    ]
    assert made.parts[1].fields["buffer.damper_curve"].points() == [[0.1, 3.0], [0.2, 6.5]]
