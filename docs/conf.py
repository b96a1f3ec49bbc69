"""Settings of the documentation's site: `make docs` builds it into build/docs."""

import re
from pathlib import Path

ROOT = Path(__file__).parent.parent

project = "mobilegs"
author = "The mobilegs authors"
copyright = "The mobilegs authors, Apache-2.0"
release = re.findall(r'__version__ = "([^"]+)"', (ROOT / "mobilegs/__init__.py").read_text())[0]

extensions = ["myst_parser"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "mobilegs"
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "source_repository": "https://github.com/mobilegs/mobilegs/",
    "source_branch": "main",
    "source_directory": "docs/",
}
