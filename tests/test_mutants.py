"""Which faults are put into a file, and that those named as equivalent are faults of today's source."""

from pathlib import Path

from verify.mutants.__main__ import ROOT, equivalents, summary
from verify.mutants.changes import mutants
from verify.mutants.child import Answer
from verify.mutants.places import ROOMS, chosen, sources
from verify.mutants.tree import Broken
from verify.mutants.trial import _verdict

PACKAGE = ROOT / "src" / "jaxbuffer"
SOURCE = '''"""A docstring - with 1 sign."""
LIMIT = 2.0  # ½


def area(x: float | None = 3, *, strict=False) -> float:
    """Of 2 * x."""
    if x is None or x < 0:
        raise ValueError(f"{x - 1} is below 0")
    x -= 1
    return -x ** 2 + LIMIT * len(list(zip([x], [x], strict=True)))
'''
EXPECTED = {
    ("2.0", "2.2"), ("2.0", "4.0"), ("3", "4"), ("3", "2"), ("False", "True"), ("or", "and"), ("is", "is not"),
    ("<", "<="), ("<", ">"), ("0", "1"), ("0", "(-1)"), ("-=", "+="), ("1", "2"), ("1", "0"), ("-", ""), ("**", "*"),
    ("2", "3"), ("2", "1"), ("+", "-"), ("*", "/"),
}  # fmt: skip


def written(folder: Path) -> Path:
    (folder / "own.py").write_text(SOURCE)
    return folder


def changed(source: bytes, fault) -> bytes:
    return source[: fault.start] + fault.new.encode() + source[fault.end :]


def test_operators_signs_comparisons_and_constants(tmp_path):
    """But none of text, annotations, what is raised, and the strictness of zip."""
    found = mutants(written(tmp_path), "own.py")
    assert {(fault.old, fault.new) for fault in found} == EXPECTED
    assert len({fault.key for fault in found}) == len(found)
    texts = {changed(SOURCE.encode(), fault) for fault in found}
    assert len(texts) == len(found)
    for text in texts:
        compile(text, "own.py", "exec")
    limits = [fault.names for fault in found if fault.old == "2.0"]
    assert limits == [("LIMIT",)] * 2


def test_a_fault_is_there_for_as_long_as_it_is_tried(tmp_path):
    package = tmp_path / "src" / "jaxbuffer"
    package.mkdir(parents=True)
    fault = mutants(written(package), "own.py")[-1]
    sound = (package / "own.py").stat().st_mtime
    with Broken(tmp_path, fault):
        assert (package / "own.py").read_bytes() == changed(SOURCE.encode(), fault)
        assert (package / "own.py").stat().st_mtime != sound
    assert (package / "own.py").read_text() == SOURCE


def test_the_choice_is_the_same_again_and_as_many_from_each_room():
    first, again, other = (chosen(PACKAGE, 60, seed) for seed in (1, 1, 2))
    assert first == again != other
    rooms = [fault.path.split("/")[0] for fault in first]
    assert {room: rooms.count(room) for room in ROOMS} == dict.fromkeys(ROOMS, 10)
    assert chosen(PACKAGE, 30, 1) == first[:30]
    assert not any("drawing" in path or "summary" in path for path in sources(PACKAGE))


def test_what_is_named_as_equivalent_is_a_fault_of_the_source_and_has_a_reason():
    known = {fault.key for path in sources(PACKAGE) for fault in mutants(PACKAGE, path)}
    named = equivalents()
    assert set(named) <= known
    assert all(reason.strip() for reason in named.values())


def test_verdicts():
    passed, failed = ({"test": "a", "outcome": outcome, "said": said} for outcome, said in
                      (("passed", ""), ("failed", "assert 1 == 2")))  # fmt: skip
    broken = {"test": "", "outcome": "unimportable", "said": "TypeError"}
    assert _verdict(Answer(0, [passed], 1.0)) == ("survived", "", "")
    assert _verdict(Answer(1, [passed, failed], 1.0)) == ("killed", "a", "assert 1 == 2")
    assert _verdict(Answer(2, [broken], 1.0))[0] == "unimportable"
    assert _verdict(Answer(4, [], 1.0))[0] == "unimportable"
    assert _verdict(Answer(-24, [passed], 1.0)) == ("timeout", "after a", "")
    assert _verdict(Answer(-9, [], 1.0)) == ("timeout", "at the first test", "")
    assert _verdict(Answer(-11, [passed], 1.0))[0] == "killed"
    assert _verdict(Answer(3, [], 1.0))[0] == "killed"


def test_survivors_are_named():
    records = [{"mutant": "run/a.py: x", "verdict": "killed"}, {"mutant": "hybrid/b.py: y", "verdict": "survived"}]
    lines = summary(records, 3)
    assert "2 of 3 tried" in lines
    assert lines[-1] == "survived: hybrid/b.py: y"
    assert "| all | 1 | 0 | 0 | 0 | 1 | 0 |" in lines
