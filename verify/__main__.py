"""Run every check, break the physics, run the papers' studies, and write docs/generated/verified.md."""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from jaxbuffer.pages.verification import FILE
from jaxbuffer.papers import PAPERS

from . import report, run
from .breakages import BREAKAGES
from .packaged import packaged

PARTS = ("tests", "breakages", "paper")
PAGE = run.ROOT / "docs" / "generated" / "verified.md"


def main() -> int:
    """The exit status: 1 where a test failed, a breakage went unnoticed, or a check cannot fail."""
    options = _parsed()
    folder = options.output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    status = 0
    if "tests" in options.only:
        status |= int(run.tests(folder, options.quick, options.jobs) != 0)
    if "breakages" in options.only:
        print(f"{len(BREAKAGES)} breakages, {options.jobs} at a time", flush=True)
        run.breakages(folder, options.jobs, _told)
    if "paper" in options.only:
        for paper in PAPERS:
            command = [
                sys.executable,
                "-m",
                "jaxbuffer",
                "reproduce",
                paper,
                "--output",
                str(folder / paper),
                "--force",
            ]
            done = subprocess.run(command, cwd=run.ROOT, env=run.environment(), stdout=subprocess.DEVNULL, check=False)
            status |= int(done.returncode != 0)
    report.note_state(folder, options.only)
    broken = _read(folder / "breakages.json", [])
    unnoticed = report.uncaught(broken)
    page = report.page(folder)
    options.page.parent.mkdir(parents=True, exist_ok=True)
    options.page.write_text(page, encoding="utf-8")
    counted = packaged(_read(folder / "evidence.json", []), folder / "tests.xml", broken)
    if counted is not None and not options.quick and set(options.only) == set(PARTS):
        FILE.write_text(json.dumps(counted, indent=2) + "\n")
    print(page)
    print(f"wrote {options.page}", *unnoticed, sep="\n")
    return int(bool(status or unnoticed))


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m verify", description=__doc__)
    parser.add_argument(
        "--only", type=lambda text: text.split(","), default=list(PARTS), metavar="PART,…", help=", ".join(PARTS)
    )
    parser.add_argument("--quick", action="store_true", help="leave the slow tests out")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes at a time; default: all cores")
    parser.add_argument("--output", type=Path, default=run.RESULTS, help="folder of what is measured")
    parser.add_argument("--page", type=Path, default=PAGE, help="default: docs/generated/verified.md")
    options = parser.parse_args()
    if unknown := set(options.only) - set(PARTS):
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    return options


def _told(record: dict[str, Any]) -> None:
    caught = [check for check, answer in record["checks"].items() if answer == "failed"]
    print(f"  {record['name']}: {'caught by ' + ', '.join(caught) if caught else 'NOT CAUGHT'}", flush=True)


def _read(path: Path, otherwise: Any) -> Any:
    return json.loads(path.read_text()) if path.exists() else otherwise


if __name__ == "__main__":
    sys.exit(main())
