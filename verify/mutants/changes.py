"""Small faults that a line of source could hold: one operator, sign, comparison or constant is another."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

BINARY = {
    ast.Add: ("+", ("-",)),
    ast.Sub: ("-", ("+",)),
    ast.Mult: ("*", ("/",)),
    ast.Div: ("/", ("*",)),
    ast.Pow: ("**", ("*",)),
    ast.FloorDiv: ("//", ("*",)),
    ast.Mod: ("%", ("*",)),
    ast.BitAnd: ("&", ("|",)),
    ast.BitOr: ("|", ("&",)),
}
COMPARED = {
    ast.Lt: ("<", ("<=", ">")),
    ast.LtE: ("<=", ("<", ">=")),
    ast.Gt: (">", (">=", "<")),
    ast.GtE: (">=", (">", "<=")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
    ast.Is: ("is", ("is not",)),
    ast.IsNot: ("is not", ("is",)),
    ast.In: ("in", ("not in",)),
    ast.NotIn: ("not in", ("in",)),
}
DECLARED = {"number", "whole", "choice", "field", "isinstance", "NewType"}  # calls whose arguments are no physics
WORDS = {"__repr__", "__str__", "__doc__"}


class Mutant(NamedTuple):
    """One fault: the file below the package, the bytes from ``start`` to ``end`` of it replaced by ``new``.

    ``line`` and ``last`` are those of the statement (or of a compound one's head) that holds it; ``names`` are what
    the statement assigns where it stands outside functions, else empty.
    """

    path: str
    start: int
    end: int
    old: str
    new: str
    at: int
    line: int
    last: int
    text: str
    names: tuple[str, ...]

    @property
    def key(self) -> str:
        """What it is called in the log and in the list of equivalent ones; it holds no line's number."""
        return f"{self.path}: {self.text}: {self.old} → {self.new} at {self.at}"


def mutants(package: Path, path: str) -> list[Mutant]:
    """All faults that one file of the package could hold."""
    source = (package / path).read_bytes()
    found = _Found(path, source)
    for statement in ast.parse(source).body:
        found.statement(statement, False)
    return found.mutants


class _Found:
    """Walks through a file's statements and gathers."""

    def __init__(self, path: str, source: bytes) -> None:
        self.path, self.source, self.mutants = path, source, list[Mutant]()
        self.lines = source.splitlines(keepends=True)
        self.starts = [0]
        for line in self.lines:
            self.starts.append(self.starts[-1] + len(line))

    def statement(self, node: ast.stmt, inside: bool) -> None:
        """One statement, ``inside`` a function or not, and those in it."""
        if isinstance(node, ast.Raise | ast.Import | ast.ImportFrom | ast.Assert):
            return
        if isinstance(node, ast.FunctionDef) and node.name in WORDS:
            return
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        heads = [it for it in ast.iter_child_nodes(node) if isinstance(it, ast.expr) and it is not _annotation(node)]
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            heads = [it for it in node.args.defaults + node.args.kw_defaults if it] if hasattr(node, "args") else []
        if isinstance(node, ast.With):
            heads = [item.context_expr for item in node.items]
        body = [
            it for it in ast.iter_child_nodes(node) if isinstance(it, ast.stmt | ast.ExceptHandler | ast.match_case)
        ]
        last = max((it.end_lineno or it.lineno for it in heads), default=node.lineno)
        if isinstance(node, ast.FunctionDef):  # a default counts when the function is called
            last = node.end_lineno or last
        self.place = (node.lineno, last, () if inside else _assigned(node))
        if isinstance(node, ast.AugAssign):
            self.operator(node.target, node.value, *BINARY[type(node.op)], suffix="=")
        for head in heads:
            self.expression(head)
        for part in body:
            within = inside or isinstance(node, ast.FunctionDef)
            for statement in [part] if isinstance(part, ast.stmt) else part.body:
                self.statement(statement, within)

    def expression(self, node: ast.AST) -> None:
        """One expression and those in it."""
        if isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str)):
            return
        if isinstance(node, ast.keyword) and node.arg == "strict":  # of zip
            return
        if isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in DECLARED:
            return
        if isinstance(node, ast.BinOp) and type(node.op) in BINARY and not _of_words(node):
            self.operator(node.left, node.right, *BINARY[type(node.op)])
        if isinstance(node, ast.BoolOp):
            word, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                self.operator(left, right, word, (other,))
        if isinstance(node, ast.Compare):
            for left, op, right in zip([node.left, *node.comparators], node.ops, node.comparators, strict=False):
                self.operator(left, right, *COMPARED[type(op)])
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not | ast.Invert):
            sign = {ast.USub: "-", ast.Not: "not ", ast.Invert: "~"}[type(node.op)]
            self.add(self.offset(node), self.offset(node) + len(sign), "")
        if isinstance(node, ast.Constant):
            for new in _others(node.value):
                self.add(self.offset(node), self.offset(node, True), new)
        for child in ast.iter_child_nodes(node):
            self.expression(child)

    def operator(self, left: ast.expr, right: ast.expr, old: str, others: tuple[str, ...], suffix: str = "") -> None:
        """The operator between two operands, by each that could stand there."""
        start, end = self.offset(left, True), self.offset(right)
        between = self.source[start:end].decode()
        bare = re.sub(r"#[^\n]*", lambda it: " " * len(it.group()), between)
        pattern = r"\s+".join(map(re.escape, old.split())) + re.escape(suffix)
        found = re.search(rf"\b{pattern}\b" if old[0].isalpha() else pattern, bare)
        assert found is not None, (self.path, between, old)
        begin = start + len(between[: found.start()].encode())
        for new in others:
            self.add(begin, begin + len(found.group().encode()), new + suffix)

    def offset(self, node: ast.expr, end: bool = False) -> int:
        """Where a node starts or ends, in bytes."""
        line, column = (node.end_lineno, node.end_col_offset) if end else (node.lineno, node.col_offset)
        return self.starts[line - 1] + column  # type: ignore[operator]

    def add(self, start: int, end: int, new: str) -> None:
        """One fault, with the line that it stands in."""
        number = max(k for k, begin in enumerate(self.starts) if begin <= start)
        line, last, names = self.place
        text = self.lines[number].decode().strip()
        at = len(self.source[self.starts[number] : start].decode().lstrip())
        old = self.source[start:end].decode()
        self.mutants.append(Mutant(self.path, start, end, old, new, at, line, last, text, names))


def _others(value: object) -> Iterator[str]:
    """Constants that could stand for one: of whole numbers the neighbours, of others a tenth more and twice as much."""
    if isinstance(value, bool):
        yield str(not value)
    elif isinstance(value, int):
        yield from (str(value + 1), str(value - 1) if value else "(-1)")
    elif isinstance(value, float):
        yield from ("1.0", "(-1.0)") if value == 0.0 else (repr(1.1 * value), repr(2.0 * value))


def _annotation(node: ast.stmt) -> ast.expr | None:
    return node.annotation if isinstance(node, ast.AnnAssign) else None


def _assigned(node: ast.stmt) -> tuple[str, ...]:
    """Names that a statement outside functions binds."""
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    return tuple(name.id for target in targets if target for name in ast.walk(target) if isinstance(name, ast.Name))


def _of_words(node: ast.BinOp) -> bool:
    """Whether an operand is text or a type: then it is no arithmetic."""
    sides = [node.left, node.right]
    text = any(isinstance(s, ast.JoinedStr) or (isinstance(s, ast.Constant) and s.value is None) for s in sides)
    text |= any(isinstance(s, ast.Constant) and isinstance(s.value, str) for s in sides)
    return text or (
        isinstance(node.op, ast.BitOr) and all(isinstance(s, ast.Name) and s.id[0].isupper() for s in sides)
    )
