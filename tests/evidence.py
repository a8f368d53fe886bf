"""What a test measured, kept for docs/generated/verified.md: claim, measured error, tolerance, source."""

import json
import os
from pathlib import Path
from typing import Any


class Evidence:
    """Call it with what was measured: it fails the test above the tolerance and remembers the worst of each claim.

    **Arguments** of a call: ``topic`` and ``claim``: where and what it stands for in the report; ``measured``: an
    error, not negative; ``tolerance``: the most it may be; ``source``: what it is measured against; ``unit``;
    ``detail``: the figures behind it, if they say more than the error does.
    """

    def __init__(self) -> None:
        self.records: dict[tuple[str, str], dict[str, Any]] = {}

    def __call__(
        self,
        topic: str,
        claim: str,
        measured: float,
        tolerance: float,
        source: str,
        unit: str = "",
        detail: str = "",
    ) -> None:
        measured, tolerance = float(measured), float(tolerance)
        test = os.environ.get("PYTEST_CURRENT_TEST", "").split(" ")[0].split("[")[0]
        record = {"topic": topic, "claim": claim, "measured": measured, "tolerance": tolerance, "source": source}
        self.add([{**record, "unit": unit, "detail": detail, "test": test, "count": 1}])
        text = f"{claim}: {measured:.3g} {unit} against {tolerance:.3g} ({source}) {detail}"
        assert 0.0 <= measured <= tolerance, text

    def add(self, records: list[dict[str, Any]]) -> None:
        """What was measured, here or in another process: the worst of each claim is kept."""
        for other in records:
            record = self.records.setdefault((other["topic"], other["claim"]), {"measured": -1.0, "count": 0})
            count = record["count"] + other["count"]
            if not other["measured"] <= record["measured"]:
                record.update(other)
            record["count"] = count

    def write(self, path: Path) -> None:
        """All records as JSON."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(list(self.records.values()), indent=1, ensure_ascii=False))
