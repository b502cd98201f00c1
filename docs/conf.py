"""Settings of the documentation site; `make docs` builds it."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

import gallery_pictures

import spiraltrunk

project = "spiraltrunk"
author = "The spiraltrunk maintainers"
copyright = "the spiraltrunk maintainers, Apache-2.0"
version = release = spiraltrunk.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "generated_tables",
    "mathtext_svg",
    "plain_docstrings",
    "cli_reference",
    "public_module",
    "root_pages",
    "short_names",
]
exclude_patterns = [
    "_build",
    "studies",
    "_ext",
    "**/sg_execution_times.rst",
    "sg_execution_times.rst",
    "examples/**/*.ipynb",
    "examples/**/*.py",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
nitpicky = True
# Types of other packages; their documentation is not at hand when a site is built offline.
nitpick_ignore_regex = [("py:.*", r"(?!spiraltrunk).*")]
default_role = "py:obj"
# Quotes and ellipses; two dashes begin an option.
smartquotes_action = "qe"
# The tables name things as they are imported, whatever module defines them.
suppress_warnings = ["config.cache", "autosummary.import_cycle"]

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence", "attrs_inline", "attrs_block"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True}
autosummary_generate = False
napoleon_numpy_docstring = False
napoleon_use_rtype = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"
add_module_names = False

html_theme = "furo"
html_title = "spiraltrunk"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathtext_svg"
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1b5e7d", "color-brand-content": "#1b5e7d"},
    "dark_css_variables": {"color-brand-primary": "#7cc4e8", "color-brand-content": "#7cc4e8"},
}
copybutton_prompt_text = "$ "

# Examples run once and again when they have changed; they take less than a minute on a quiet core.
sphinx_gallery_conf = {
    "examples_dirs": ["../examples"],
    "gallery_dirs": ["examples"],
    "filename_pattern": r"/\d",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": (gallery_pictures.scrape,),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
}
