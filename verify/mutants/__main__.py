"""Put random small faults into the source, one at a time, and see whether the quick tests notice (docs/mutants.md)."""

import argparse
import json
import sys
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

from . import reach as reaching
from .changes import Mutant
from .child import preload
from .places import ROOMS, chosen
from .tree import copied
from .trial import control, tried

ROOT = Path(__file__).resolve().parents[2]
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
VERDICTS = ("killed", "timeout", "unimportable", "equivalent", "survived", "unreached")
CONTROLS = 60  # faults between two runs of tests without one


def main() -> int:
    """The exit status: 1 where a fault survived that is not listed as equivalent."""
    options = _parsed()
    folder = options.output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "log.jsonl"
    if not options.resume:
        log.unlink(missing_ok=True)
    tree = copied(ROOT, folder / "tree")
    package = tree / "src" / "jaxbuffer"
    faults = chosen(package, options.count, options.seed)
    if not options.report:
        preload()
        if not options.tests:
            reaching.measure(tree, folder / "reach.jsonl", _told)
        reach = reaching.Reach(folder / "reach.jsonl", package)
        _all(tree, faults, reach, log, options)
    keys = {fault.key for fault in faults}
    records = [record for record in _latest(log, options.known).values() if record["mutant"] in keys]
    print(*summary(records, len(faults)), sep="\n")
    if options.keep:
        kept = [{name: record[name] for name in ("mutant", "verdict", "by")} for record in records]
        options.keep.write_text(json.dumps(kept, indent=0, ensure_ascii=False) + "\n")
    return int(any(record["verdict"] in ("survived", "unreached") for record in records))


def _all(tree: Path, faults: list[Mutant], reach: reaching.Reach, log: Path, options: argparse.Namespace) -> None:
    """Try what has no verdict yet or, with ``--again``, what survived."""
    known, equivalent = _latest(log, options.known), equivalents()
    tries = 0
    for number, fault in enumerate(faults, 1):
        before = known.get(fault.key)
        if before and not (before["verdict"] in ("survived", "unreached") and options.again):
            continue
        if fault.key in equivalent or (options.only and number not in options.only):
            continue
        if tries % CONTROLS == 0 and not options.tests and (wrong := control(tree, fault, reach, options.seconds)):
            _told(f"without a fault: {wrong}")
        tries += 1
        record = tried(tree, fault, reach, options.seconds, options.tests)
        with log.open("a") as file:
            file.write(json.dumps(record, ensure_ascii=False) + "\n")
        _told(f"{number:3} {record['verdict']:12} {record['seconds']:5.0f} s  {fault.key}  {record['by']}")


def equivalents() -> dict[str, str]:
    """Faults that change nothing that could be tested, and why."""
    return {row["mutant"]: row["reason"] for row in tomllib.loads(EQUIVALENT.read_text()).get("equivalent", [])}


def summary(records: list[dict[str, Any]], count: int) -> list[str]:
    """A table of verdicts by room, and the survivors."""
    rows = {room: Counter[str]() for room in ROOMS}
    for record in records:
        rows[record["mutant"].split("/")[0]][record["verdict"]] += 1
    lines = [f"| room | {' | '.join(VERDICTS)} |", "| --- |" + " --- |" * len(VERDICTS)]
    for room, counted in rows.items():
        lines.append(f"| {room} | {' | '.join(str(counted[verdict]) for verdict in VERDICTS)} |")
    total = Counter(record["verdict"] for record in records)
    lines.append(f"| all | {' | '.join(str(total[verdict]) for verdict in VERDICTS)} |")
    lines.append(f"{len(records)} of {count} tried")
    return lines + [f"{r['verdict']}: {r['mutant']}" for r in records if r["verdict"] in ("survived", "unreached")]


def _latest(log: Path, kept: Path | None) -> dict[str, dict[str, Any]]:
    """The latest record of each fault, else its verdict in the file ``kept``; what is listed as equivalent by now
    counts as that."""
    found = {record["mutant"]: record for record in json.loads(kept.read_text())} if kept else {}
    for line in log.read_text().splitlines() if log.exists() else ():
        record = json.loads(line)
        found[record["mutant"]] = record
    for name in equivalents():
        if name in found:
            found[name] |= {"verdict": "equivalent", "by": ""}
    return found


def _told(line: str) -> None:
    print(line, flush=True)


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m verify.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=300, help="faults, as many from each room; default: 300")
    parser.add_argument("--seed", type=int, default=1, help="of the choice; default: 1")
    parser.add_argument("--known", type=Path, help="a JSON file of --keep: what has a verdict there is not tried")
    parser.add_argument("--resume", action="store_true", help="go on with the log in the folder")
    parser.add_argument("--again", action="store_true", help="with --resume: try survivors again")
    parser.add_argument("--seconds", type=float, default=45.0, help="of tests for a fault, at most; default: 45")
    parser.add_argument("--only", type=int, nargs="+", help="these faults, by their number in the choice")
    parser.add_argument("--tests", nargs="+", default=[], help="these tests instead of those that reach a fault's line")
    parser.add_argument("--report", action="store_true", help="only count what the log says")
    parser.add_argument("--keep", type=Path, help="write the verdicts to this JSON file")
    parser.add_argument("--output", type=Path, default=Path("results/mutants"), help="folder of the log and the copy")
    options = parser.parse_args()
    options.resume |= options.again or options.report
    return options


if __name__ == "__main__":
    sys.exit(main())
