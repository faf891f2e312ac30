"""How the documentation site is made: `make docs`. Everything it shows lies in the repository; nothing is fetched."""

import sys
from pathlib import Path

import ulna

sys.path.insert(0, str(Path(__file__).parent / "site"))

project = "Ulna"
author = "the authors of Ulna"
project_copyright = "the authors of Ulna, Apache-2.0"
version = release = ulna.__version__

extensions = [
    "sphinx.ext.autodoc",
    "myst_nb",
    "sphinx_copybutton",
    "mathml",
    "complete",
    "docstrings",
    "commands",
    "exercises",
    "self_contained",
]
exclude_patterns = ["site"]

html_theme = "furo"
html_title = "Ulna"
html_logo = html_favicon = "static/ulna.svg"
html_static_path = ["static"]
html_css_files = ["ulna.css"]
html_theme_options = {"sidebar_hide_name": False, "navigation_with_keys": True}
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
smartquotes_action = "D"  # dashes alone

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
myst_url_schemes = ["http", "https", "mailto"]

# A lesson is run whenever the site is made, and an error in it fails the build.
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_code_prompt_show = "Show how this is drawn"
nb_code_prompt_hide = "Hide how this is drawn"

# Every name in a signature must lead somewhere. Other projects' names are not linked: their inventories are not here.
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|pathlib|collections|typing)\..*"),
    (
        "py:class",
        r"(ArrayLike|Array|NDArray|Path|Solid|Shape|Obstacle|HasLinks|Region|Goal|Frame|Given|GivenLimits|AbstractContextManager|Tensor)",
    ),
    ("py:class", r"(ReadsMotions|(ulna\.engine\.records\.)?Records)"),
]

autodoc_mock_imports = ["torch", "jax"]  # they are large, and only their names are needed
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings.py tells them, in the words of the source
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
copybutton_exclude = ".linenos, .gp, .go"
