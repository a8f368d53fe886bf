"""What a page says of tolerances: in how many corners the design holds, which matter, and which to tighten first."""

from ..output.folder import Results
from .limits import corners_verdict
from .page import PageSection, Table
from .records import sentence


def tolerances(results: Results) -> PageSection | None:
    """Return what a tuning with tolerances showed in their corners; None without tolerances."""
    tuned = results.tuned
    if tuned is None or not tuned.get("tolerances"):
        return None
    lines = [sentence(line) for line in tuned["corners"]["lines"]]
    spread, holds = tuned.get("spread"), not corners_verdict(tuned)
    # What breaks a limit is a warning, what holds a fact.
    text, warnings = (lines, []) if holds else (lines[-1:], lines[:-1])
    if spread is None:
        return PageSection("Tolerances", text, warnings=warnings)
    table = Table(spread["caption"], spread["headings"], spread["rows"])
    advice, *others = [sentence(line) for line in spread["lines"]] or [""]
    return PageSection(
        "Tolerances", [*text, *([advice] if advice else [])], tables=[table], warnings=[*warnings, *others]
    )
