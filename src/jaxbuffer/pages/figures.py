"""Figures of a folder, as parts of a page."""

import base64
import re

from ..output.folder import Results
from .page import Figure

ACTIVE = re.compile(r"<script|<foreignObject|javascript:|\son\w+=", re.IGNORECASE)  # what no figure of ours holds


def figure(found: Results, stem: str, caption: str) -> list[Figure]:
    """The figure of that name, if the folder has it: an SVG rather than a PNG."""
    svg, png = found.folder / f"{stem}.svg", found.folder / f"{stem}.png"
    if svg.is_file() and not ACTIVE.search(text := svg.read_text(encoding="utf-8")):
        return [Figure(caption, svg=_inline(text, re.sub(r"\W+", "-", f"{found.folder}-{stem}").strip("-")))]
    if png.is_file():
        return [Figure(caption, png=base64.b64encode(png.read_bytes()).decode())]
    return []


def _inline(svg: str, prefix: str) -> str:
    """An SVG file as part of a page: without its head, no larger than it was drawn, its identifiers made its
    own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', svg)
    svg = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", svg)
    width = re.search(r'<svg\b[^>]*? width="([\d.]+)pt"', svg)
    for size in ("width", "height"):
        svg = re.sub(rf'(<svg\b[^>]*?) {size}="[^"]*"', r"\1", svg, count=1)
    return svg if width is None else svg.replace("<svg", f'<svg style="--natural: {width[1]}pt"', 1)
