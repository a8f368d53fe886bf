"""Pages of the documentation, and the examples on them."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def blocks(page: Path) -> str:
    """A page's Python examples, one after the other."""
    return "\n".join(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))


def commands(page: Path) -> str:
    """A page's shell examples, one after the other, but for those that a comment above marks as not run."""
    parts = re.findall(r"(<!-- not run.*?-->\n)?```bash\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    return "\n".join(text for comment, text in parts if not comment)


DOCS = ROOT / "docs"
HOWTO = sorted((DOCS / "howto").glob("*.md"))
GUIDES = [
    *(
        DOCS / f"{name}.md"
        for name in ("quickstart", "clusters", "laws", "gradients", "tuning", "robust", "tank_drop", "choose")
    ),
    *HOWTO,
]
PAGES = [page for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md")), *HOWTO) if blocks(page)]
