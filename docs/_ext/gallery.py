"""The gallery: each script of docs/gallery is run by the build; its ``figure`` and its code become a page.

A script begins with a docstring in Markdown, whose first line is the title, and leaves a matplotlib ``figure``.
"""

import os
import runpy
import time
import warnings
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

PAGE = """{heading}

![{title}]({name}.png)

```python
{code}
```
"""


def make(app: Sphinx) -> None:
    """Run the scripts and write the gallery's pages, before Sphinx looks for its sources."""
    import jaxbuffer

    source = Path(app.srcdir)
    target = source / "generated" / "gallery"
    target.mkdir(parents=True, exist_ok=True)
    cache = os.environ.get("JAXBUFFER_CACHE", Path.home() / ".cache" / "jaxbuffer")
    jaxbuffer.configure(cache=cache)
    scripts = sorted((source / "gallery").glob("*.py"))
    for old in set(target.glob("*")) - {target / f"{it.stem}{kind}" for it in scripts for kind in (".md", ".png")}:
        old.unlink()
    cards = [_page(script, target) for script in scripts]
    names = "\n".join(script.stem for script in scripts)
    intro = "Each figure is made by the build of these pages, by the code beneath it."
    shown = "\n\n".join(f"[![{title}]({name}.png) {title}]({name}.md)" for name, title in cards)
    (target / "index.md").write_text(
        f"# Gallery\n\n{intro}\n\n```{{container}} cards\n{shown}\n```\n\n```{{toctree}}\n:hidden:\n\n{names}\n```\n",
        encoding="utf-8",
    )


def _page(script: Path, target: Path) -> tuple[str, str]:
    """The page and the figure of a script; its name and title."""
    begun = time.monotonic()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        names = runpy.run_path(str(script))
    names["figure"].savefig(target / f"{script.stem}.png", dpi=110)
    logging.getLogger(__name__).info("gallery: %s in %.1f s", script.name, time.monotonic() - begun)
    heading = names["__doc__"].strip()
    title = heading.splitlines()[0].removeprefix("# ")
    code = script.read_text(encoding="utf-8").split('"""\n', 2)[1].strip()
    page = PAGE.format(heading=heading, title=title, name=script.stem, code=code)
    (target / f"{script.stem}.md").write_text(page, encoding="utf-8")
    return script.stem, title


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", make)
    return {"parallel_read_safe": True}
