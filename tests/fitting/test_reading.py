"""Tables of tests: what is read, and what is refused with file, line and column."""

import numpy as np
import pytest

import jaxbuffer as jb

UNITS = {"stroke": "m", "active_acceleration_x": "m/s²", "hinge_angle": "rad"}
CHANNELS = {"stroke [mm]": jb.Channel("stroke"), "a [m/s2]": jb.Channel("active_acceleration_x")}
PLAIN = "time [s],stroke [mm],a [m/s2]\n0,1,0.5\n0.1,2,0.25\n0.2,3,-1e-1\n"


def read(tmp_path, text, channels=CHANNELS, **others):
    file = tmp_path / "test.csv"
    file.write_text(text, encoding="utf-8")
    return jb.read_recording(file, channels, units=UNITS, **others)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.replace(",", ";"),
        PLAIN.replace(",", "\t"),
        PLAIN.replace(",", ";").replace(".", ","),
        "\ufeff" + PLAIN.replace("\n", "\r\n"),
        "a [m/s2];comment;stroke [mm];time [s]\n0,5;x;1;0\n\n0,25;y;2;0,1\n-1e-1;;3;0,2\n",
        '"stroke [mm]","time [s]","a [m/s2]"\n1,0,0.5\n2,0.1,0.25\n3,0.2,-0.1\n',
        '"stroke [mm]", "time [s]", "a [m/s2]"\n1, 0, 0.5\n2, 0.1, 0.25\n3, 0.2, -0.1\n',
        "# bench 3\n" + PLAIN.replace("0.1,2", "# a comment\n0.1,2"),
    ],
)
def test_delimiters_decimal_commas_and_any_order_give_the_same(tmp_path, text):
    test = read(tmp_path, text)
    assert test.name == "test.csv" and np.allclose(test.times, [0.0, 0.1, 0.2], rtol=0, atol=1e-15)
    assert np.allclose(test.values["stroke [mm]"], [1e-3, 2e-3, 3e-3]) and np.allclose(
        test.values["a [m/s2]"], [0.5, 0.25, -0.1]
    )


def test_units_are_those_of_the_headings(tmp_path):
    text = "t [ms],angle [deg],stroke\n0,0,0.1\n5,180,0.2\n"
    channels = {"angle [deg]": jb.Channel("hinge_angle"), "stroke": jb.Channel("stroke")}
    test = read(tmp_path, text, channels, time="t [ms]")
    assert test.times[1] == pytest.approx(0.005) and test.values["angle [deg]"][1] == pytest.approx(np.pi)
    assert test.values["stroke"][1] == 0.2


@pytest.mark.parametrize(
    "heading",
    ["stroke [mm]", "stroke (mm)", "stroke / mm", "stroke/mm", "stroke (mm) left", "stroke / (mm)", '"stroke\n[mm]"'],
)
def test_a_unit_counts_in_brackets_and_behind_a_slash(tmp_path, heading):
    test = read(tmp_path, PLAIN.replace("stroke [mm]", heading), {heading.strip('"'): jb.Channel("stroke")})
    assert np.allclose(test.values[heading.strip('"')], [1e-3, 2e-3, 3e-3])


def test_a_unit_behind_a_slash_may_have_one_itself(tmp_path):
    test = read(tmp_path, PLAIN.replace("a [m/s2]", "a / mm/s^2"), {"a / mm/s^2": CHANNELS["a [m/s2]"]})
    assert np.allclose(test.values["a / mm/s^2"], [5e-4, 2.5e-4, -1e-4])


def test_the_line_of_the_headings_is_the_files_own(tmp_path):
    with pytest.raises(jb.InputError, match=r"test.csv, line 3: there is no column"):
        read(tmp_path, "# bench\n# two\n" + PLAIN.replace("stroke", "strok"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time [s]\tstroke [mm]\n0.050\t1,194\n0.1\t3\n", 'line 2, column "stroke [mm]": 1,194 beside line 2, column'),
        ("time [s];stroke [mm]\n0;1,5\n1;2\n2;3.5\n", 'line 4, column "stroke [mm]": 3.5 beside line 2, column'),
        ('time [s],stroke [mm]\n0,"1,194"\n1,"2,181"\n', "1,194 beside commas between the cells"),
        ("time [s]\tstroke [mm]\tother\n0\t1,194\t20.5\n1\t2,1\t3\n", "20.5 beside line 2"),
        ("time [s];stroke [mm]\n0;1.194,5\n1;2\n", "line 2: column \"stroke [mm]\" has '1.194,5', which is not a"),
    ],
)
def test_a_file_has_one_decimal_mark(tmp_path, text, said):
    with pytest.raises(jb.InputError) as caught:
        read(tmp_path, text, {"stroke [mm]": jb.Channel("stroke")})
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("heading", "said"), [("a (filtered)", "filtered"), ("a [g]", "g is a gram; multiply"), ("a / V", "V")]
)
def test_what_names_no_unit_is_refused(tmp_path, heading, said):
    with pytest.raises(jb.InputError) as caught:
        read(tmp_path, PLAIN.replace("a [m/s2]", heading), {heading: jb.Channel("active_acceleration_x")})
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("stroke [mm]", "strok [mm]", 'test.csv, line 1: there is no column "stroke [mm]"; did you mean strok [mm]?'),
        ("0.1,2,", "0.1,nan,", """test.csv, line 3: column "stroke [mm]" has 'nan', which is not a finite number"""),
        ("0.1,2,", "0.1,inf,", """line 3: column "stroke [mm]" has 'inf'"""),
        ("0.1,2,", "0.1,,", 'line 3: column "stroke [mm]" is empty'),
        ("0.1,2,", "0.1,two,", """line 3: column "stroke [mm]" has 'two'"""),
        ("0.1,2,0.25", "0.1,2", "test.csv, line 3 has 2 cells, and line 1 names 3 columns"),
        ("0.2,3", "0.1,3", 'line 4: column "time [s]" has 0.1, which is there twice'),
        ("0.2,3", "0.05,3", 'line 4: column "time [s]" has 0.05, which is earlier than that of the line before'),
        ("a [m/s2]", "stroke [mm]", 'test.csv, line 1: column "stroke [mm]" is there twice'),
    ],
)
def test_what_is_wrong_in_a_table_is_named_with_its_line_and_column(tmp_path, old, new, said):
    assert old in PLAIN
    with pytest.raises(jb.InputError) as error:
        read(tmp_path, PLAIN.replace(old, new))
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("heading", "channel", "said"),
    [
        ("stroke [s]", jb.Channel("stroke"), "line 1: column \"stroke [s]\" = '1 s': s is a time, expected"),
        ("stroke [mm] [m]", jb.Channel("stroke"), 'line 1: column "stroke [mm] [m]" has two units; keep one'),
        ("stroke [mm]", jb.Channel("strok"), 'column "stroke [mm]": quantity strok is unknown; did you mean stroke?'),
        ("stroke [mm]", jb.Channel("stroke", noise=0.02), 'noise = 0.02 has no unit: write noise = "0.02 mm"'),
        ("stroke [mm]", jb.Channel("stroke", offset=(-2, 0)), 'offset = -2 has no unit: write offset = "-2 mm"'),
    ],
)
def test_units_and_quantities_that_do_not_fit_are_refused(tmp_path, heading, channel, said):
    with pytest.raises(jb.InputError) as error:
        read(tmp_path, PLAIN.replace("stroke [mm]", heading), {heading: channel})
    assert said in str(error.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(jb.InputError, match=r"none\.csv: no such file"):
        jb.read_recording(tmp_path / "none.csv", CHANNELS, units=UNITS)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# time [s], stroke [mm]\n0,1\n0.1,2\n", "line 2: numbers in place of headings, 0 say; if line 1 has them"),
        ("# bench 4\n#time [s];stroke [mm]\n0;0\n1;1\n", "if line 2 has them, take the # away"),
        ("0,1\n0.1,2\n0.2,3\n", "line 1: numbers in place of headings, 0 say"),
        ("# time [s], stroke [mm]\na,b\n0.1,2\n1,2\n", 'no column "time [s]"; line 1 has it behind a #'),
    ],
)
def test_headings_in_a_comment_are_named(tmp_path, text, said):
    with pytest.raises(jb.InputError) as caught:
        read(tmp_path, text, {"stroke [mm]": jb.Channel("stroke")})
    assert said in str(caught.value)
