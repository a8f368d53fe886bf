"""Starting quickly: nothing heavy is imported before it is needed, and no public name is lost by that."""

import dataclasses
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from typer.main import get_command

import jaxbuffer
from jaxbuffer.cli import commands
from jaxbuffer.cli.app import app
from jaxbuffer.cli.options import SHARED
from jaxbuffer.tuning.problem.settings import Settings
from jaxbuffer.version import version

SOURCE = Path(jaxbuffer.__file__).resolve().parents[1]


def loaded_by(code: str) -> set[str]:
    """Top-level modules that a fresh interpreter has after running ``code``."""
    program = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); {code}; print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return {name.split(".")[0] for name in done.stderr.split()}


@pytest.mark.parametrize(
    "code",
    [
        "import jaxbuffer",
        "from jaxbuffer import InputError",
        "from jaxbuffer.cli.entry import run; run(['--help'])",
    ],
)
def test_neither_the_package_nor_its_help_imports_jax_or_numpy(code):
    assert not loaded_by(code) & {"jax", "numpy", "equinox", "diffrax", "optax", "matplotlib"}


def test_a_commands_help_imports_jax_once(tmp_path, monkeypatch):
    """It lists fields, which the mechanisms say; their names are kept until the package changes."""
    monkeypatch.setenv("JAXBUFFER_CACHE", str(tmp_path))
    code = "from jaxbuffer.cli.entry import run; run(['sweep', '--help'])"
    assert "jax" in loaded_by(code)
    assert not loaded_by(code) & {"jax", "numpy", "equinox", "diffrax", "optax", "matplotlib"}


def test_what_a_command_does_takes_the_options_that_its_help_shows():
    """Its signature is written twice, so that help need not import what it does."""
    modules = [
        importlib.import_module(f"{commands.__name__}.{it.name}") for it in pkgutil.iter_modules(commands.__path__)
    ]
    for name, command in get_command(app).commands.items():
        own = name.replace("-", "_")
        defined = [vars(module)[own] for module in modules if own in vars(module)]
        (function,) = [it for it in defined if it.__module__.startswith(commands.__name__)]
        taken, shown = {*inspect.signature(function).parameters}, {parameter.name for parameter in command.params}
        if "search" in taken:  # the settings of a search, as keywords that nothing else is passed among
            taken = taken - {"search"} | (shown & {field.name for field in dataclasses.fields(Settings)})
        assert taken - {"request"} == (shown - {*SHARED} if "request" in taken else shown), name


@pytest.mark.parametrize(
    ("code", "more"),
    # SciPy's own modules are imported when they are first used: a command may have the package.
    [
        ("from jaxbuffer import simulate, table2, Scenario", {"scipy"}),
        ("import jaxbuffer.cli.commands.simulate", set()),
    ],
)
def test_a_capture_needs_no_optimiser_no_figure_and_none_of_diffrax(code, more):
    """A program that is compiled already holds the coefficients of diffrax's methods."""
    modules = loaded_by(code)
    assert "jax" in modules and not modules & {"optax", "matplotlib", "diffrax", "optimistix", "xarray", *more}


def test_every_public_name_is_there_and_listed():
    assert set(jaxbuffer.__all__) <= set(dir(jaxbuffer))
    assert jaxbuffer.__all__ == sorted(jaxbuffer.__all__)
    for name in jaxbuffer.__all__:
        assert callable(getattr(jaxbuffer, name))
    with pytest.raises(AttributeError, match="has no attribute 'simulat'"):
        jaxbuffer.simulat  # noqa: B018


def test_no_room_or_module_at_the_top_shares_its_name_with_a_public_function():
    package = Path(jaxbuffer.__file__).parent
    beside = {path.stem for path in package.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert not beside & set(jaxbuffer.__all__)


def test_the_version_is_that_of_pyproject_and_said_without_jax():
    project = tomllib.loads((SOURCE.parent / "pyproject.toml").read_text())["project"]
    assert jaxbuffer.__version__ == version() == project["version"]
    assert "jax" not in loaded_by("import jaxbuffer; jaxbuffer.__version__")


def test_type_checkers_are_told_that_there_are_annotations():
    assert (Path(jaxbuffer.__file__).parent / "py.typed").is_file()


def test_the_order_of_the_mechanisms_does_not_depend_on_which_was_imported_first():
    code = "import {}; from jaxbuffer.mechanisms import all_mechanisms; print(*[it.name for it in all_mechanisms()])"
    program = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); {code.format('jaxbuffer.mechanisms.slider_crank')}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["probe_cone", "docking3d", "bar_drop", "slider_crank", "tank_drop"]


def test_version_changelog_and_citation_name_the_same_release():
    root = SOURCE.parent
    release = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    cited = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    headings = re.findall(r"^## (.*)$", (root / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    latest = next(heading for heading in headings if heading != "Unreleased")
    assert cited["version"] == release["version"] and cited["license"] == release["license"]
    assert latest == f"{cited['version']} ({cited['date-released']})"
    assert {"cff-version", "message", "title", "authors"} <= cited.keys()  # without which it is no valid one
