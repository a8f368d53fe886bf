"""The page of what was measured, generated/verified.md: from the results of `make verify`, if it was run."""

from pathlib import Path

from sphinx.application import Sphinx

from verify import report, run


def make(app: Sphinx) -> None:
    """Write the page, before Sphinx looks for its sources."""
    target = Path(app.srcdir) / "generated" / "verified.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text(report.page(run.RESULTS), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", make)
    return {"parallel_read_safe": True}
