"""Which quick tests reach which lines, and the tests that a fault is tried against."""

import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .changes import Mutant
from .child import run_tests

# Files of the first tier, cheap ones first. Each is run in a process of its own, for programs that tests share are
# traced by the first of them only.
FILES = (
    "tests/contact/test_geometry.py", "tests/contact/test_laws.py", "tests/contact/test_impact.py",
    "tests/contact/test_pair.py", "tests/contact/test_forces.py", "tests/contact/test_damping.py",
    "tests/contact/test_pin_in_hole.py", "tests/multibody/test_joints.py", "tests/multibody/test_elements.py",
    "tests/multibody/test_solution.py", "tests/multibody/test_motion.py", "tests/multibody/test_trigonometry.py",
    "tests/multibody/test_momentum.py", "tests/hybrid/test_crossing.py", "tests/hybrid/test_bracketing.py",
    "tests/hybrid/test_prediction.py", "tests/hybrid/test_controller.py", "tests/hybrid/test_stages.py",
    "tests/hybrid/test_log.py", "tests/hybrid/test_transitions.py", "tests/hybrid/test_batched_map.py",
    "tests/test_certificate.py", "tests/run/test_instants.py", "tests/run/test_impacts.py",
    "tests/run/test_largest.py", "tests/run/test_kept_steps.py", "tests/run/test_read_off.py",
    "tests/test_tight_solves.py",
    "tests/contact/test_pressure.py", "tests/contact/test_time_scale.py", "tests/contact/test_voigt.py",
    "tests/hybrid/test_fastest.py", "tests/hybrid/test_tableaus.py", "tests/hybrid/test_moving_by_hand.py",
    "tests/mechanisms/test_slider_crank_parts.py", "tests/mechanisms/test_loss_factor.py",
    "tests/mechanisms/test_margins.py", "tests/mechanisms/test_ball_contact.py", "tests/mechanisms/test_bent_bars.py",
    "tests/test_trust.py", "tests/test_differences.py", "tests/test_evidence.py", "tests/test_quantities.py",
    "tests/mechanisms/test_start.py", "tests/mechanisms/test_augmented.py", "tests/mechanisms/test_inputs.py",
    "tests/mechanisms/test_rod_modes.py", "tests/mechanisms/test_diagnosis.py", "tests/mechanisms/test_watched.py",
    "tests/mechanisms/test_slider_crank_statistics.py", "tests/multibody/test_flexible_elements.py",
    "tests/multibody/test_flexible_bars.py", "tests/multibody/test_flexible_solution.py",
    "tests/multibody/test_flexible_joints.py", "tests/multibody/test_flexible_planar.py",
    "tests/verification/test_reference.py", "tests/mechanisms/test_conservation.py",
    "tests/mechanisms/test_bar_drop.py", "tests/verification/test_closed_forms.py",
    "tests/mechanisms/test_published_slider_crank.py", "tests/multibody/test_flexible_energy.py",
    "tests/multibody/test_flexible_motion.py", "tests/multibody/test_flexible_spin.py", "tests/hybrid/test_orders.py",
    "tests/hybrid/test_solvers.py", "tests/hybrid/test_kernel.py", "tests/hybrid/test_moving.py",
    "tests/hybrid/test_flexible_loop.py", "tests/hybrid/test_diffeqsolve.py", "tests/verification/test_balance.py",
    "tests/mechanisms/test_slider_crank.py", "tests/mechanisms/test_bending_probe.py",
    "tests/mechanisms/test_hinge_play.py", "tests/mechanisms/test_end_stop.py",
    "tests/mechanisms/test_struck_beam.py", "tests/mechanisms/test_bar_drop_plate.py",
    "tests/mechanisms/test_bending_rod.py", "tests/multibody/test_struck.py",
    "tests/multibody/test_flexible_slider_crank.py", "tests/verification/test_first_impact.py",
    "tests/verification/test_gradients.py", "tests/verification/test_buffer_end.py",
    "tests/verification/test_rigid_probe.py", "tests/verification/test_smooth_law.py",
    "tests/test_derivatives_everywhere.py", "tests/test_effective_energy.py",
    "tests/verification/test_elasticities.py",
)  # fmt: skip
LONGEST = 240.0  # s of the processor for a file while lines are noted
CHEAP = 1.0  # s: tests of a file that share a program with one that reaches a line are run too if they take less


def measure(tree: Path, kept: Path, told: Callable[[str], None]) -> None:
    """Note for every test of `FILES` how long it takes and which lines it is the first to reach, unless it is known."""
    done = {record["file"]: record["digest"] for record in _records(kept)}
    for name in FILES:
        digest = hashlib.sha256((tree / name).read_bytes()).hexdigest()
        if done.get(name) == digest:
            continue
        answer = run_tests(tree, [name], LONGEST, reach=True)
        told(f"{name}: {len(answer.notes)} tests in {answer.seconds:.0f} s, status {answer.status}")
        with kept.open("a") as file:
            record = {"file": name, "digest": digest, "status": answer.status, "tests": answer.notes}
            file.write(json.dumps(record) + "\n")


def _records(kept: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []


class Reach:
    """What `measure` found."""

    def __init__(self, kept: Path, package: Path) -> None:
        self.package = package
        self.tests: list[dict[str, Any]] = []
        for record in {record["file"]: record for record in _records(kept)}.values():
            own = [dict(test, file=record["file"]) for test in record["tests"] if test["outcome"] == "passed"]
            for test in own:
                test["lines"] = {path: set(lines) for path, lines in test["lines"].items()}
            self.tests += own

    def checks(self, mutant: Mutant, budget: float) -> tuple[list[str], float]:
        """Tests that reach a fault, the quickest first, and the cheap ones beside them; and how long they take [s].

        A fault outside functions is reached by those that reach a line where what the statement binds is named, or,
        where there are none, a line of the same folder.
        """
        places = self._places(mutant)
        reaching = [test for test in self.tests if any(places[p] & test["lines"].get(p, set()) for p in places)]
        if not reaching and mutant.names:  # named at import only, as a table is
            folder = mutant.path.rpartition("/")[0]
            reaching = [test for test in self.tests if any(path.rpartition("/")[0] == folder for path in test["lines"])]
        first, spent, files = [], 0.0, []
        for test in sorted(reaching, key=lambda test: test["seconds"]):
            if first and spent + test["seconds"] > budget:
                break
            spent += test["seconds"]
            first.append(test["test"])
            files.append(test["file"])
        chosen, spent_beside = list(first), 0.0
        for test in sorted((test for test in self.tests if test["file"] in files), key=lambda test: test["seconds"]):
            if test["test"] in first or test["seconds"] > CHEAP or spent_beside > budget / 2.0:
                continue
            spent_beside += test["seconds"]
            chosen.append(test["test"])
        return chosen, spent + spent_beside

    def _places(self, mutant: Mutant) -> dict[str, set[int]]:
        if not mutant.names:
            return {mutant.path: set(range(mutant.line, mutant.last + 1))}
        word = re.compile(r"\b(" + "|".join(mutant.names) + r")\b")
        found = {}
        for path in {path for test in self.tests for path in test["lines"]}:
            text = (self.package / path).read_text()
            lines = text.splitlines()
            if path != mutant.path and not re.search(rf"import .*\b({'|'.join(mutant.names)})\b", text):
                continue
            if named := {k for k, line in enumerate(lines, 1) if word.search(line)}:
                found[path] = named
        return found
