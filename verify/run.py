"""The two runs behind the report: the tests with their evidence, and the breakages, each in a process of its own."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from .breakages import BREAKAGES, Breakage

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "results" / "verify"
CLAIMING = (  # folders of tests that carry the claims
    *("tests/properties", "tests/hybrid", "tests/verification", "tests/multibody", "tests/mechanisms"),
    *("tests/structures", "tests/composites", "tests/shock", "tests/contact", "tests/docking3d"),
)
LIMIT = 900  # s for the checks of one breakage


def tests(folder: Path, quick: bool, jobs: int) -> int:
    """Run the tests that carry the claims; evidence.json and tests.xml in ``folder``. The exit status."""
    command = [sys.executable, "-m", "pytest", *CLAIMING, "-q", "--evidence", folder / "evidence.json"]
    command += ["-n", jobs, "--dist", "loadfile"]
    command += ["--junitxml", folder / "tests.xml", *(("-m", "not slow") if quick else ())]
    return subprocess.run([str(word) for word in command], cwd=ROOT, env=environment(), check=False).returncode


def breakages(folder: Path, jobs: int, done: Callable[[dict[str, Any]], None]) -> list[dict[str, Any]]:
    """Run every breakage against its checks; what each check said, in breakages.json."""

    def one(breakage: Breakage) -> dict[str, Any]:
        record = _broken(breakage, folder)
        done(record)
        return record

    with ThreadPoolExecutor(jobs) as pool:
        records = list(pool.map(one, BREAKAGES))
    (folder / "breakages.json").write_text(json.dumps(records, indent=1, ensure_ascii=False))
    return records


def _broken(breakage: Breakage, folder: Path) -> dict[str, Any]:
    report = folder / f"broken-{breakage.name.replace(' ', '-')}.json"
    report.unlink(missing_ok=True)
    command = [sys.executable, "-m", "pytest", "-p", "verify.broken", "--broken", breakage.name]
    command += ["--broken-report", str(report), "-q", "--tb=line", *breakage.checks]
    if not all("::" in check for check in breakage.checks):  # whole files without their slow tests
        command += ["-m", "not slow"]
    try:
        subprocess.run(command, cwd=ROOT, env=environment(), capture_output=True, timeout=LIMIT, check=False)
        heard = json.loads(report.read_text())
    except (subprocess.TimeoutExpired, FileNotFoundError):
        heard = {}
    checks = {check: _said(check, heard) for check in breakage.checks}
    return {"name": breakage.name, "what": breakage.what, "checks": checks}


def _said(check: str, heard: dict[str, list[str]]) -> str:
    """What one check (a file, a test or one of its cases) made of a breakage: the strongest of its tests' answers."""
    for answer in ("failed", "crashed", "passed"):
        if any(node == check or node.startswith((check + "::", check + "[")) for node in heard.get(answer, [])):
            return answer
    return "not run"


def environment() -> dict[str, str]:
    """This process's, with the checkout on Python's path."""
    paths = [str(ROOT), str(ROOT / "src"), os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(path for path in paths if path)}
