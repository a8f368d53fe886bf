"""Formulas as MathML, which browsers draw themselves: the pages load no script and need no network."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

RAISED = re.compile(r"\\begin\{pmatrix\}((?:(?!\\end).)*)\\end\{pmatrix\}(?=[\^_])", re.DOTALL)
MATRIX = re.compile(r"<mo>&#x00028;</mo>(<mtable>.*?</mtable>)<mo>&#x00029;</mo>", re.DOTALL)
FENCED = r'<mrow><mo fence="true" stretchy="true">(</mo>\1<mo fence="true" stretchy="true">)</mo></mrow>'


def formula(text: str, display: str) -> str:
    """MathML of LaTeX; what the converter lacks is said in words that it has."""
    text = text.replace("{aligned}", "{align*}")
    text = RAISED.sub(r"{\\begin{pmatrix}\1\\end{pmatrix}}", text)
    return MATRIX.sub(FENCED, convert(text, display=display))


def inline(writer: HTML5Translator, node: nodes.math) -> None:
    """A formula in a line."""
    writer.body.append(f'<span class="math">{formula(node.astext(), "inline")}</span>')
    raise nodes.SkipNode


def block(writer: HTML5Translator, node: nodes.math_block) -> None:
    """A formula in lines of its own."""
    writer.body.append(f'<div class="math" tabindex="0">{formula(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True}
