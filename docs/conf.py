"""Sphinx configuration.

Pages are MyST Markdown. Code cells are executed at build time, and a failing cell fails the
build. `_ext/from_declarations.py` writes the reference tables from the package itself.
Formulas are set by the MathJax copy in `_static`, without a network connection.
"""

import functools
import gc
import os
import sys
from importlib.metadata import version as installed
from pathlib import Path

from sphinx.search.en import SearchEnglish

gc.set_threshold(100_000, 20, 50)  # trees of nodes are full of cycles, looked for too often
SearchEnglish.stem = functools.cache(SearchEnglish.stem)  # the same words are on many pages

HELPERS = str(Path(__file__).parent / "_ext")
sys.path.insert(0, HELPERS)


def in_front(variable: str, folder: str) -> None:
    """Put a folder in front of a search path that the pages inherit."""
    os.environ[variable] = os.pathsep.join(filter(None, [folder, os.environ.get(variable)]))


in_front("PYTHONPATH", HELPERS)  # for page_setup
in_front("PATH", str(Path(sys.executable).parent))  # for the command `martensite`

project = "martensite"
author = "The martensite developers"
copyright = "The martensite developers"
release = version = installed("martensite")

extensions = [
    "myst_nb",
    "executed",
    "shown",
    "live",
    "gallery",
    "navigation",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "from_declarations",
]
INCLUDED = ["reference/benchmarks.md", "reference/machines.md"]
"""Generated sections of other pages."""
exclude_patterns = ["_build", "jupyter_execute", "_static/**", "_ext/**", "_figures/**", *INCLUDED]

# -- pages -------------------------------------------------------------------------------
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# -- the bench beside it, if there is one ------------------------------------------------
live_bench = os.environ.get("MARTENSITE_BENCH", "")

# -- code cells --------------------------------------------------------------------------
pages_begin_with = ["warm"]
nb_execution_mode = "force"  # outputs belong to the package as it is now
nb_execution_in_temp = True
nb_execution_timeout = 300  # beside the tests, on few cores
nb_merge_streams = True

# -- docstrings --------------------------------------------------------------------------
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_class_signature = "separated"
autodoc_default_options = {"exclude-members": "__init__, __new__"}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
add_module_names = False

# -- output ------------------------------------------------------------------------------
html_theme = "furo"
html_title = f"martensite {release}"
html_static_path = ["_static"]
html_css_files = ["tables.css", "gallery.css"]
html_show_sourcelink = False
html_copy_source = False
mathjax_path = "mathjax/tex-svg.js"
mathjax3_config = {"options": {"enableMenu": False}}
