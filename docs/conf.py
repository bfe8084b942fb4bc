"""Settings of the documentation site, which `make docs` builds into `site/` with Sphinx."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import logging

import understudy
import understudy.spi
import understudy.testing

project = "Understudy"
author = "The Understudy authors"
project_copyright = "the Understudy authors, Apache-2.0"
version = release = understudy.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.autosummary"]
root_doc = "index"
exclude_patterns = ["pictures", "_templates"]
templates_path = ["_templates"]
html_theme = "furo"
html_title = f"Understudy {release}"
html_static_path: list[str] = []
html_show_sphinx = False
html_copy_source = False

myst_enable_extensions = ["colon_fence", "html_image"]
myst_heading_anchors = 4
suppress_warnings = ["myst.xref_ambiguous"]

autosummary_generate = True
autosummary_ignore_module_all = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
napoleon_google_docstring = False
napoleon_use_rtype = False
python_use_unqualified_type_names = True

_log = logging.getLogger(__name__)
MODULES = (understudy, understudy.spi, understudy.testing)
"""Every public name of these must be in the reference."""


def _check_coverage(_: Sphinx, env: BuildEnvironment) -> None:
    """Warn, which fails the build, about a public name that no page of the reference documents."""
    documented = env.domains["py"].data["objects"]
    for module in MODULES:
        for name in module.__all__:
            if not any(f"{each.__name__}.{name}" in documented for each in MODULES):
                _log.warning(
                    "%s.%s is not in the reference", module.__name__, name, location=_find(module, name)
                )


def _find(module: Any, name: str) -> str:
    value = getattr(module, name)
    try:
        return f"{Path(inspect.getsourcefile(value) or '')}:{inspect.getsourcelines(value)[1]}"
    except TypeError:  # a constant
        return f"{module.__file__}:1"


LABORATORY = Path(__file__).parents[1] / "src" / "understudy_lab"
STUDIES = Path(__file__).parent / "reference" / "studies"
_STUDY_LINK = re.compile(r"\]\((?:\.\./)+src/understudy_lab/(\w+)/README\.md")


def _include_studies(_: Sphinx) -> None:
    """Make a page of each README of the laboratory, which lie beside their code."""
    STUDIES.mkdir(parents=True, exist_ok=True)
    for readme in LABORATORY.glob("*/README.md"):
        include = f"```{{include}} ../../../{readme.relative_to(LABORATORY.parents[1]).as_posix()}\n```\n"
        page = STUDIES / f"{readme.parent.name}.md"
        if not page.exists() or page.read_text() != include:
            page.write_text(include)


def _link_studies(app: Sphinx, name: str, source: list[str]) -> None:
    up = "../" * name.count("/")
    source[0] = _STUDY_LINK.sub(rf"]({up}reference/studies/\1.md", source[0])


def setup(app: Sphinx) -> None:
    """Add the check of the reference, and the laboratory's pages."""
    app.add_lexer("csv", TextLexer)
    app.connect("builder-inited", _include_studies)
    app.connect("source-read", _link_studies)
    app.connect("env-check-consistency", _check_coverage)
