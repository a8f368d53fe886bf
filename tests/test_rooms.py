"""The rooms of the package: imports go down one list, none in a circle, and what is generic names no mechanism."""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

import jaxbuffer

PACKAGE = Path(jaxbuffer.__file__).parent
TOP = PACKAGE.name

# A room imports only from rooms above it; "" is the package itself, whose public names are imported when asked for.
ROOMS = (
    *("errors", "files", "program_files", "process", "threads", "identity", "structure"),
    *("tables", "progress", "version", "_types", "fields", "labelled", "plane", "multibody"),
    *(
        "contact",
        "composites",
        "shock",
        "structures",
        "cache",
        "cluster",
        "hybrid",
        "mechanisms",
        "run",
        "sensitivities",
        "sweeps",
        "tuning",
        "experiments",
    ),
    *("study", "output", "papers", "report", "", "cli", "__main__"),
)
HYBRID = (
    *("system", "trees", "sensitivity", "rungekutta", "events", "options", "loop"),
    *("diffrax_problem", "locate_events", "diffeqsolve", "event_times", "solve"),
    "",  # the room's own list of names
)
# Outside its own folder and the papers' studies, the probe-cone mechanism is named here only.
NAMED = (
    "__init__.py",  # for type checkers
    "mechanisms/__init__.py",  # the list of mechanisms
    "study/config.py",  # the default kind
    "tuning/cases.py",
    "cli/laws.py",
    "output/laws_figure.py",
)


class Import(NamedTuple):
    """An import of one of our modules by another, both dotted names without the package's; ``when``: "loading" at
    module level, "calling" inside a function, "printing" inside `__repr__`, "typing" for type checkers only."""

    module: str
    imported: str
    when: str
    line: int


def modules() -> dict[str, Path]:
    """Every module by its dotted name without the package's; a package goes by its own name."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = modules()


def statements(node: ast.AST, when: str = "loading") -> Iterator[tuple[ast.Import | ast.ImportFrom, str]]:
    """All import statements below a node, and when they run."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, when
        elif isinstance(child, ast.If) and ast.unparse(child.test).endswith("TYPE_CHECKING"):
            for inner in child.body:
                yield from statements(ast.Module([inner], []), "typing")
            for inner in child.orelse:
                yield from statements(ast.Module([inner], []), when)
        elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) and when != "typing":
            printing = "__repr__" in (getattr(child, "name", ""), when)
            yield from statements(child, "printing" if printing or when == "printing" else "calling")
        else:
            yield from statements(child, when)


def targets(module: str, path: Path, statement: ast.Import | ast.ImportFrom) -> Iterator[str]:
    """Which of our modules a statement imports: of ``from .a import b`` the module a.b if there is one, else a."""
    if isinstance(statement, ast.Import):
        for alias in statement.names:
            first, _, rest = alias.name.partition(".")
            if first == TOP:
                yield rest
        return
    if statement.level:
        package = module.split(".") if module else []
        package = package if path.name == "__init__.py" else package[:-1]
        base = [*package[: len(package) - statement.level + 1], *(statement.module or "").split(".")]
    elif (statement.module or "").partition(".")[0] == TOP:
        base = statement.module.split(".")[1:]
    else:
        return
    source = ".".join(filter(None, base))
    for alias in statement.names:
        inner = f"{source}.{alias.name}".lstrip(".")
        yield inner if inner in MODULES else source


def read(module: str, path: Path) -> Iterator[Import]:
    """All imports of our modules by one of them."""
    for statement, when in statements(ast.parse(path.read_text(encoding="utf-8"))):
        for target in targets(module, path, statement):
            yield Import(module, target, when, statement.lineno)


IMPORTS = [found for module, path in MODULES.items() for found in read(module, path)]


def told(found: Import) -> str:
    return f"{TOP}.{found.module}:{found.line} imports {found.imported or TOP} ({found.when})"


def test_all_imports_are_of_modules_there_are():
    assert len(MODULES) > 100 and len(IMPORTS) > 300
    assert {found.when for found in IMPORTS} == {"loading", "calling", "printing", "typing"}
    assert [told(found) for found in IMPORTS if found.imported not in MODULES] == []


def test_every_module_is_in_a_room():
    assert {module.split(".")[0] for module in MODULES} == set(ROOMS)
    assert {module.partition(".")[2].split(".")[0] for module in MODULES if module.split(".")[0] == "hybrid"} == set(
        HYBRID
    )


def upwards(rooms: tuple[str, ...], imports: list[tuple[str, str, Import]]) -> list[str]:
    """Those imports, from one room to another, that go up."""
    return [told(found) for own, other, found in imports if rooms.index(other) > rooms.index(own)]


@pytest.mark.parametrize("when", ["loading", "calling", "printing"])
def test_imports_go_down_the_list_of_rooms(when):
    between = [
        (found.module.split(".")[0], found.imported.split(".")[0], found)
        for found in IMPORTS
        if found.when == when and found.module  # the package itself names them all
    ]
    assert upwards(ROOMS, between) == []


def test_imports_go_down_the_list_inside_hybrid():
    inside = [
        (found.module.partition(".")[2].split(".")[0], found.imported.partition(".")[2].split(".")[0], found)
        for found in IMPORTS
        if found.when != "typing" and all(name.split(".")[0] == "hybrid" for name in found[:2])
    ]
    assert len(inside) > 30
    assert upwards(HYBRID, inside) == []


def circle(graph: dict[str, set[str]]) -> list[str]:
    """A circle in a directed graph, its first node at the end again; empty if there is none."""
    done: set[str] = set()

    def visit(node: str, way: list[str]) -> list[str]:
        if node in way:
            return [*way[way.index(node) :], node]
        if node not in done:
            for following in sorted(graph.get(node, ())):
                if found := visit(following, [*way, node]):
                    return found
            done.add(node)
        return []

    return next((found for node in sorted(graph) if (found := visit(node, []))), [])


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]
    assert circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_no_modules_import_each_other_in_a_circle():
    """Imports inside functions count, too; only a result that prints itself may ask the module that tells of it."""
    graph: dict[str, set[str]] = {}
    for found in IMPORTS:
        if found.when in ("loading", "calling"):
            graph.setdefault(found.module, set()).add(found.imported)
    assert circle(graph) == []


def test_what_is_generic_names_no_mechanism():
    naming = {
        str(path.relative_to(PACKAGE))
        for path in MODULES.values()
        if "probe_cone" in path.read_text(encoding="utf-8")
        and not path.is_relative_to(PACKAGE / "mechanisms" / "probe_cone")
        and not path.is_relative_to(PACKAGE / "papers")
    }
    assert naming <= set(NAMED)
