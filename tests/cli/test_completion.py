"""What a shell offers at a press of the tabulator."""

import os
import subprocess
import sys

import pytest

from jaxbuffer.cli import completion
from jaxbuffer.contact.laws import LAWS
from jaxbuffer.fields import addresses, meaning, metadata, paths
from jaxbuffer.mechanisms import mechanism_named

PROGRAM = """
import sys
from jaxbuffer.cli.entry import main
try:
    main([])
finally:
    print("JAX" if "jax" in sys.modules else "no JAX", file=sys.stderr)
"""


@pytest.fixture(autouse=True)
def _cache(monkeypatch, programs):
    monkeypatch.setenv("JAXBUFFER_CACHE", str(programs))
    completion._all_names.cache_clear()
    completion.names([])


def offered(typed, folder=None, shell="bash"):
    """What a shell offers behind ``typed``, and what is written on stderr."""
    words = f"jaxbuffer {typed}"
    asked = {"_JAXBUFFER_COMPLETE": f"complete_{shell}", "_TYPER_COMPLETE_ARGS": words, "COMP_WORDS": words}
    asked |= {"COMP_CWORD": str(len(words.split()) - (not words.endswith(" ")))}
    asked |= {"_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    found = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        check=False,
        capture_output=True,
        text=True,
        env=os.environ | asked,
        cwd=folder,
        timeout=120,
    )
    return found.stdout.split("\n")[:-1] if found.stdout.strip() else [], found.stderr.strip()


@pytest.mark.slow
def test_names_are_kept_so_that_no_key_press_waits_for_jax(tmp_path, monkeypatch):
    monkeypatch.setenv("JAXBUFFER_CACHE", str(tmp_path / "new"))
    laws, first = offered("simulate --contact.law ")
    assert laws == list(LAWS) and first == "JAX"
    for typed, expected in (
        ("simulate --contact.law h", [law for law in LAWS if law.startswith("h")]),
        ("simulate study.toml --contact.law = he", ["hertz", "herbert-mcwhannell"]),  # bash cuts --contact.law=he up
        ("sweep --over contact.law = hertz,ex", ["hertz,exact"]),
        ("sweep --over contact.l", ["contact.law=", "contact.linear_stiffness="]),
    ):
        assert offered(typed) == (expected, "no JAX"), typed


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("simulate --buffer.k_A 8 --buffer.k_A 9 --tr", ["--trust"]),
        ("simulate --output= --sol", ["--solver"]),
        ("tune study.toml --lev", ["--levers"]),
        ("choose study.toml --levers ", ["on", "off"]),
        ("simulate --buffer.k_A ", []),
        ("simulate --nonsense.field ", []),
    ],
)
def test_it_prints_no_error_into_the_prompt(typed, expected):
    assert offered(typed) == (expected, "no JAX")


def test_fields_are_those_of_the_study_s_mechanism(tmp_path):
    (tmp_path / "drop.toml").write_text('kind = "bar_drop"\n')
    found, _ = offered("simulate drop.toml --pl", tmp_path)
    plate = [path for path in paths(mechanism_named("bar_drop").design()) if path.startswith("plate.")]
    assert found == [f"--{path}" for path in plate] and plate
    (tmp_path / "drop.toml").write_text("kind = ")  # half written
    assert offered("simulate drop.toml --shock.d", tmp_path)[0] == ["--shock.damping"]


def test_fish_shows_what_a_field_means():
    assert offered("simulate --buffer.k_A", shell="fish")[0] == ["--buffer.k_A\tstiffness along the cylinder [N/m]"]
    assert offered("sensitivity --of hinge_angle", shell="fish")[0][0].startswith("hinge_angle\t")


@pytest.mark.parametrize("shell", ["fish", "zsh"])
@pytest.mark.parametrize("study", ["", "study.toml "])
def test_zsh_and_fish_hold_a_field_and_its_value_in_one_word(shell, study):
    found, error = offered(f"simulate {study}--contact.law=he", shell=shell)
    laws = [f"--contact.law={law}" for law in LAWS if law.startswith("he")]
    assert len(laws) > 1 and all(law in " ".join(found) for law in laws) and error == "no JAX"
    assert "=le" not in " ".join(found)
    assert not any("k_A" in it for it in offered(f"simulate {study}--buffer.k_A=5", shell=shell)[0])


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], ("", "")),
        (["simulate"], ("", "")),
        (["simulate", "--contact.law"], ("--contact.law", "")),
        (["simulate", "--contact.law", "="], ("--contact.law", "")),
        (["simulate", "--contact.law", "hertz"], ("", "")),
        (["sweep", "--over", "contact.law", "="], ("--over", "contact.law=")),
        (["sweep", "--over", "="], ("", "")),
        (["sweep", "--output", "a", "="], ("", "")),
    ],
)
def test_the_option_whose_value_is_typed(words, expected):
    assert completion.pending(words) == expected


@pytest.mark.parametrize("kind", ["probe_cone", "docking3d", "bar_drop", "slider_crank", "tank_drop"])
def test_every_field_and_quantity_is_known(kind, tmp_path):
    (study := tmp_path / "study.toml").write_text(f'kind = "{kind}"\n')
    mechanism, known = mechanism_named(kind), completion.names([str(study)])
    assert list(known["fields"]) == [
        path for path in addresses(mechanism.design(), mechanism.scenario()) if path in known["fields"]
    ]
    parts = {"": mechanism.design(), "scenario.": mechanism.scenario()}
    assert set(known["fields"]) == {prefix + path for prefix, part in parts.items() for path in paths(part)}
    assert set(known["quantities"]) == set(mechanism.quantities)
    assert all(it["doc"] for group in (known["fields"], known["quantities"]) for it in group.values())


def test_a_folder_that_cannot_be_written_or_a_damaged_file_costs_time_alone(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("JAXBUFFER_CACHE", str(tmp_path / "file"))
    completion._all_names.cache_clear()
    assert completion.names([])["fields"]
    monkeypatch.setenv("JAXBUFFER_CACHE", str(tmp_path))
    completion._all_names.cache_clear()
    completion.names([])
    (kept,) = tmp_path.glob("names-*.json")
    kept.write_text("{")
    completion._all_names.cache_clear()
    assert completion.names([])["fields"]
    assert kept.read_text().startswith('{"probe_cone"')


@pytest.mark.parametrize(("shell", "line"), [("fish", "{}\t{}"), ("zsh", '"{}":"{}"')])
@pytest.mark.parametrize(("typed", "name"), [("simulate --scenario.", "scenario"), ("simulate --buffer.", "buffer")])
def test_each_field_is_offered_in_a_line_with_its_unit(shell, line, typed, name):
    """As its declaration has it: neither markup nor the width of a terminal take anything away."""
    mechanism = mechanism_named("probe_cone")
    part = mechanism.scenario() if name == "scenario" else getattr(mechanism.design(), name)
    lines, _ = offered(typed, shell=shell)
    for path in paths(part):
        known = metadata(part, path)
        unit = f" [{known['unit']}]" if "unit" in known else ""
        escaped = f"{meaning(part, path)}{unit}"
        if shell == "zsh":
            escaped = escaped.replace("'", "''").replace(":", "\\\\:")
        assert any(line.format(f"--{name}.{path}", escaped) in it for it in lines), path
    if shell == "fish":
        assert all(it.startswith(f"--{name}.") for it in lines)


def test_the_units_of_options_are_offered_too():
    lines, _ = offered("simulate --dur", shell="fish")
    assert lines == ["--duration\tSimulated time until timeout [s]; default: the mechanism's."]
