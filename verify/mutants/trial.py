"""One fault against its tests, and the verdict."""

import signal
from pathlib import Path
from typing import Any

from .changes import Mutant
from .child import Answer, run_tests
from .reach import Reach
from .tree import Broken

BEYOND = 60.0  # s that a fault may add
NAMED = 200.0  # s of the processor that tests named by hand may take
COLLECTION = (2, 4)  # how pytest ends where a file can't be imported


def tried(tree: Path, mutant: Mutant, reach: Reach, budget: float, named: list[str]) -> dict[str, Any]:
    """What became of a fault: ``killed`` (by which test), ``survived``, ``timeout``, ``unimportable``, ``unreached``.

    **Arguments:** ``tree``: the copy; ``budget``: s of the processor that its tests may take on sound source;
    ``named``: tests to run instead of those that reach it.
    """
    record: dict[str, Any] = {"mutant": mutant.key, "line": mutant.line}
    checks, seconds = (named, NAMED) if named else reach.checks(mutant, budget)
    if not checks:
        return record | {"verdict": "unreached", "by": "", "said": "", "seconds": 0.0, "tests": 0}
    with Broken(tree, mutant):
        answer = run_tests(tree, checks, 1.5 * seconds + BEYOND)
    verdict, by, said = _verdict(answer)
    told = {"verdict": verdict, "by": by, "said": said, "seconds": round(answer.seconds, 1)}
    return record | told | {"tests": len(checks)}


def control(tree: Path, mutant: Mutant, reach: Reach, budget: float) -> str:
    """What fails without a fault, "" for nothing: then a failure with it is the fault's."""
    checks, seconds = reach.checks(mutant, budget)
    verdict, by, said = _verdict(run_tests(tree, checks, 1.5 * seconds + BEYOND)) if checks else ("survived", "", "")
    return "" if verdict == "survived" else f"{verdict} {by}: {said}"


def _verdict(answer: Answer) -> tuple[str, str, str]:
    failed = next((note for note in answer.notes if note["outcome"] != "passed" and note["said"]), None)
    if failed is not None and failed["outcome"] == "failed":
        return "killed", failed["test"], failed["said"]
    if failed is not None or answer.status in COLLECTION:
        return "unimportable", "", failed["said"] if failed else "the tests could not be collected"
    if answer.status in (-signal.SIGXCPU, -signal.SIGKILL):
        return "timeout", _after(answer), ""
    if answer.status < 0:
        return "killed", _after(answer), f"the process ended by signal {-answer.status}"
    return ("survived", "", "") if answer.status == 0 else ("killed", "", f"pytest ended with {answer.status}")


def _after(answer: Answer) -> str:
    return f"after {answer.notes[-1]['test']}" if answer.notes else "at the first test"
