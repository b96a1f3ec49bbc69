"""The built web viewer: page, scripts and shaders in `dist`, which `make viewer` writes."""

import base64
import hashlib
import html
import re
from functools import cache
from pathlib import Path

DIST = Path(__file__).parent / "dist"
# the viewer's page, and what it loads from files beside it: workers, shaders, and parts that few
# visits need
SCRIPTS = (
    "viewer.js",
    "worker.js",
    "wgsl.js",
    "glsl.js",
    "webgl.js",
    "formats.js",
    "languages.js",
    "extras.js",
    "report.js",
    "xr.js",
)
# parts of index.html that pages replace
SCRIPT = '<script type="module" src="viewer.js"></script>'
TITLE = "<title>mobilegs</title>"
# characters that are shown as their numbers: controls, and those that turn the text after them
UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")


@cache
def index_page() -> str:
    """The page with one `<mobile-gs>`; callers replace `SCRIPT` and `TITLE`."""
    return _read("index.html")


@cache
def script(name: str) -> str:
    """One of `SCRIPTS`.

    The page shows the scene that its address names, or else the one in the element with the id
    `scene` (base64), or else the one that `<mobile-gs>` names.
    """
    assert name in SCRIPTS
    return _read(name)


@cache
def element_script() -> str:
    """The custom element `<mobile-gs>`, as one script.

    With the attribute `page` the element is a whole page, as that of `viewer.js`.
    """
    return _read("mobile-gs.js")


@cache
def editor_script() -> str:
    """The tools of the editor, as one script, for a page with the viewer's script."""
    return _read("edit.js")


@cache
def live_page() -> str:
    """The page of a training; callers replace `TITLE`."""
    return _read("live.html")


@cache
def live_script() -> str:
    """The script of `live_page`."""
    return _read("live.js")


def service_worker() -> str:
    """The script that keeps an exported site on the device."""
    return _read("service_worker.js")


def shader(name: str) -> str:
    """The WGSL of the shader with the given name."""
    return _read(f"{name}.wgsl")


@cache
def version_of(text: str) -> str:
    """The first 16 hexadecimal digits of a script's SHA-256: the query of its address."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def script_tags(path: str) -> str:
    """The HTML that starts the viewer, to follow its element; `path` is that of its script.

    The addresses of scripts contain their versions, so that browsers may cache them forever.
    """
    address = f"{path}?{version_of(script('viewer.js'))}"
    preload = f"<script>{preload_script()}</script>"
    return f'{preload}\n    <script type="module" src="{address}"></script>'


@cache
def preload_script() -> str:
    """The script that stands in pages before the viewer's own."""
    return f"\n{_read('preload.js').strip()}\n"


@cache
def content_policy(*inline: str, beside: bool = True) -> str:
    """The Content-Security-Policy of a page with the viewer, for a header or a `<meta>`.

    Of the scripts in the page only those of `inline` run. `beside`: the page may load what its own
    host has, such as the scene and parts of the viewer. No other host is ever asked.
    """
    own = ["'self'"] if beside else []
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in inline]
    directives = {
        "default-src": [],
        "script-src": [*own, *(f"'sha256-{each}'" for each in hashes), "'wasm-unsafe-eval'"],
        "worker-src": [*own, "blob:"],
        "connect-src": own,
        "manifest-src": own,
        "img-src": [*own, "data:", "blob:"],
        "style-src": ["'unsafe-inline'"],
        "base-uri": [],
        "form-action": [],
    }
    return "; ".join(" ".join([name, *(each or ["'none'"])]) for name, each in directives.items())


def policy_tag(policy: str) -> str:
    """The `<meta>` of a Content-Security-Policy, to precede everything that a file has a say in."""
    return f'<meta http-equiv="Content-Security-Policy" content="{policy}" />'


def escaped(text: str) -> str:
    r"""A text as HTML, with characters that nobody sees as numbers like \u202e.

    Bytes of file names that are not text become replacement characters.
    """
    text = text.encode(errors="surrogateescape").decode(errors="replace")
    return html.escape(UNSEEN.sub(lambda found: f"\\u{ord(found[0]):04x}", text))


def _read(name: str) -> str:
    return (DIST / name).read_text(encoding="utf-8")
