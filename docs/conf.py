"""Sphinx's settings: `make docs` builds docs/_build/html. Nothing is loaded from a network, here or by the pages."""

import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS / "_ext"), str(DOCS.parent)]  # the latter has `verify`

import jaxbuffer

project = "jaxbuffer"
release = jaxbuffer.__version__
copyright = "the authors of jaxbuffer; Apache-2.0"
extensions = ["sphinx.ext.autodoc", "myst_nb", "sphinx_copybutton", "mathml", "reference", "gallery", "verified"]
exclude_patterns = ["_build", "_ext", "gallery", "figures/*.py"]
nitpicky = True

myst_enable_extensions = ["dollarmath", "attrs_inline"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True

autodoc_typehints = "none"  # docstrings have units and shapes
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = "jaxbuffer"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
