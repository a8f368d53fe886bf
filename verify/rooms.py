"""Counts of a package's structure: `python -m verify.rooms [FOLDER]` prints rooms, arrows and circles.

A room is a folder or a loose module at the package's top; an arrow leads from one room to another that it imports at
run time; a circle is a group of modules that import one another, what is imported for type checkers only aside.
"""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

DEFAULT = Path(__file__).resolve().parents[1] / "src" / "jaxbuffer"


def modules(package: Path) -> dict[str, Path]:
    """Every module by its dotted name below the package."""
    found = {}
    for path in package.rglob("*.py"):
        parts = path.relative_to(package).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(module: str, path: Path, known: dict[str, Path]) -> Iterator[str]:
    """The package's modules that a module imports at run time."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    typing = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
        for statement in node.body
        for inner in ast.walk(statement)
    }
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or not node.level or id(node) in typing:
            continue
        own = module.split(".") if module else []
        own = own if path.name == "__init__.py" else own[:-1]
        base = ".".join([*own[: len(own) - node.level + 1], *(node.module or "").split(".")]).strip(".")
        for alias in node.names:
            inner = f"{base}.{alias.name}".strip(".")
            yield inner if inner in known else base


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules each of which leads to every other one."""
    reach = {module: set(targets) for module, targets in graph.items()}
    for middle in graph:
        for module in graph:
            if middle in reach[module]:
                reach[module] |= reach[middle]
    groups = {
        tuple(sorted(m for m in graph if m in reach[module] and module in reach[m]) or [module]) for module in graph
    }
    return [list(group) for group in groups if len(group) > 1]


def counts(package: Path) -> dict[str, int]:
    """Modules, rooms, arrows between rooms, pairs of rooms that import each other, circles and modules in them."""
    known = modules(package)
    graph = {module: {t for t in imports(module, path, known) if t != module} for module, path in known.items()}
    arrows = {(a.split(".")[0], b.split(".")[0]) for a, targets in graph.items() for b in targets}
    arrows = {(a, b) for a, b in arrows if a != b and a and b}
    found = circles(graph)
    return {
        "modules": len(known),
        "rooms": len({module.split(".")[0] for module in known if module}),
        "arrows between rooms": len(arrows),
        "pairs of rooms that import each other": sum((b, a) in arrows for a, b in arrows) // 2,
        "circles of modules": len(found),
        "modules in circles": sum(map(len, found)),
    }


if __name__ == "__main__":
    for name, count in counts(Path(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT).items():
        print(f"{name:40} {count}")
