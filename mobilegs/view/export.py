"""Export a scene with its viewer: one HTML file, or a folder for a web host."""

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import urlsplit

from PIL import Image

from mobilegs.atomic import atomic_write, open_input, read_input
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect_mgs
from mobilegs.up import Axis
from mobilegs.view.assets import (
    SCRIPT,
    SCRIPTS,
    TITLE,
    content_policy,
    element_script,
    escaped,
    index_page,
    policy_tag,
    preload_script,
    script,
    script_tags,
    service_worker,
)
from mobilegs.view.poster import SIZE, Posters, data_url, encoded, jpeg, posters_of
from mobilegs.view.serve import SUFFIXES, validate_scene_file

ICON = 512  # pixels
DESCRIPTION = "A scene in 3D, exported by mobilegs"
# files and a text in each: a folder with one of them is from `export_site`, which writes the first
# one first
SIGNATURES = {
    "manifest.webmanifest": DESCRIPTION,
    "sw.js": "`mobilegs ${",  # the name of its cache
}
UNVERIFIED = ("manifest.webmanifest", "poster.jpg", "icon.png")
HTML_MAX = 400_000_000  # bytes of a scene: strings in browsers end at 2^29 characters
# parts of index.html that exported pages replace
LINK = '<link rel="icon" href="data:," />'
ELEMENT = "<mobile-gs linkable></mobile-gs>"
HEAD_END = "</head>"
# attributes of the element whose names are not those of the notes
ATTRIBUTES = {"title": "heading", "start_portrait": "start-portrait"}
LINK_ICON = '<link rel="icon" href="icon.png" />'
# registered after loading: the service worker downloads the files it keeps once more
REGISTER = """
      const keep = async () => {
        try {
          await navigator.serviceWorker?.register("sw.js");
        } catch {
          // sandboxed frames have none, and pages over plain http may not
        }
      };
      const scene = document.querySelector("mobile-gs");
      for (const name of ["load", "error"]) scene.addEventListener(name, keep, { once: true });
    """
PREVIEW = """    <meta property="og:url" content="{}" />
    <meta property="og:type" content="website" />
    <meta name="twitter:card" content="summary_large_image" />
"""


def export_html(
    scene: Path,
    output: Path,
    *,
    title: str,
    up: Axis | None = None,
    heading: str = "",
    notes: Mapping[str, str] | None = None,
) -> int:
    """Write one HTML file with viewer and scene, which needs no server. Returns its bytes.

    `up` replaces the scene's upward direction, `heading` the title that viewers show. `notes` are
    those of a scene whose file has none. Raises InputError for a scene that the web viewer does not
    show or of more than 400 MB, and if `output` is a file that is not an exported page.
    """
    validate_scene_file(scene)
    if output.is_file() and not _is_page(output):
        raise InputError(f"{output} is not an exported page: give another name, so as to keep it")
    if scene.stat().st_size > HTML_MAX:
        raise InputError(
            f"{scene} is larger than the {HTML_MAX // 10**6} MB that browsers take in a page: "
            "use --to site"
        )
    posters = posters_of(scene, up, notes)
    poster = "" if posters.style else data_url(jpeg(posters.preview), "image/jpeg")
    given = {**posters.notes, **(notes or {})}
    element, script = embedded(scene, poster, _attributes(up, heading, given))
    page = page_with(
        {
            TITLE: f"{embedded_policy()}\n    <title>{escaped(title)}</title>",
            **_styled(posters),
            ELEMENT: element,
            SCRIPT: script,
        }
    )
    atomic_write(output, page)
    return len(page.encode())


def embedded(scene: Path, poster: str, attributes: str = "") -> tuple[str, str]:
    """Return the element and the scripts of a page that holds the viewer and a scene."""
    data = base64.b64encode(read_input(scene)).decode()
    return (
        f'<mobile-gs page{attributes} poster="{poster}"></mobile-gs>',
        f'<script type="application/octet-stream" id="scene">{data}</script>\n'
        f'    <script type="module">\n{element_script()}</script>',
    )


def embedded_policy() -> str:
    """Return the tag that keeps a page with `embedded` from loading or running anything else."""
    return policy_tag(content_policy(f"\n{element_script()}", beside=False))


def export_site(
    scene: Path,
    output: Path,
    *,
    title: str,
    url: str = "",
    up: Axis | None = None,
    heading: str = "",
    notes: Mapping[str, str] | None = None,
) -> int:
    """Write a folder for any web host, which phones can install and open offline.

    `up`, `heading` and `notes` are as in `export_html`. `url` is the address where the site will
    be: link previews need the full address of the image. Returns the bytes in the folder. Raises
    InputError for a scene that the web viewer does not show, if `output` has files that are not
    from an earlier export, and for a `url` that is not an http or https address.
    """
    validate_scene_file(scene)
    url = url and _folder_address(url)
    _validate_site_folder(output)
    posters = posters_of(scene, up, notes)
    image = posters.preview
    name, title = f"scene{scene.suffix.lower()}", escaped(title)
    files = {
        "manifest.webmanifest": _manifest(title),
        "poster.jpg": jpeg(image),
        "icon.png": _icon(image),
        **{file: script(file).encode() for file in SCRIPTS},
        "mobile-gs.js": element_script().encode(),
        name: read_input(scene),
    }
    given = {**posters.notes, **(notes or {})}
    page = _site_page(files, posters, name, title, url, _attributes(up, heading, given))
    version = hashlib.sha256(page.encode() + b"".join(files.values())).hexdigest()[:16]
    page = _replaced(
        page, {LINK_ICON: f'<meta name="version" content="{version}" />\n    {LINK_ICON}'}
    )
    worker = output / "sw.js"
    before = read_input(worker) if worker.is_file() else b""
    # browsers look at sw.js for a new version: write it last
    files |= {"index.html": page.encode(), "sw.js": _service_worker(files, name, version)}
    for file, data in files.items():
        atomic_write(output / file, data)
    for old in (f"scene{kind}" for kind in SUFFIXES):  # of an earlier export
        if old != name and json.dumps(old).encode() in before:
            (output / old).unlink(missing_ok=True)
    return sum(map(len, files.values()))


def _validate_site_folder(output: Path) -> None:
    """Raise InputError if `output` exists, is not empty and was not written by `export_site`."""
    if not output.exists() or (output.is_dir() and not any(output.iterdir())):
        return
    for file, text in SIGNATURES.items():
        path = output / file
        if path.is_file() and text.encode() in read_input(path):
            return
    raise InputError(f"{output} has files that are not from an export: give a new folder")


def _site_page(
    files: dict[str, bytes], posters: Posters, name: str, title: str, url: str, attributes: str
) -> str:
    """Return the page of a site; `title` is escaped, `name` is the scene's file."""
    # addresses that change with the files: browsers may have cached earlier ones
    poster = "" if posters.style else f"poster.jpg?{_digest(files['poster.jpg'])}"
    return page_with(
        {
            **_styled(posters),
            TITLE: f"{policy_tag(content_policy(preload_script(), REGISTER))}\n"
            f"    <title>{title}</title>\n"
            f'    <meta property="og:title" content="{title}" />\n'
            f'    <meta property="og:image" content="{html.escape(url)}poster.jpg" />\n'
            f"{PREVIEW.format(html.escape(url)) if url else ''}"
            '    <link rel="manifest" href="manifest.webmanifest" />',
            LINK: f'{LINK_ICON}\n    <link rel="apple-touch-icon" href="icon.png" />',
            ELEMENT: f'<mobile-gs src="{name}?{_digest(files[name])}"{attributes} '
            f'poster="{poster}"></mobile-gs>',
            SCRIPT: f"{script_tags('viewer.js')}\n    <script>{REGISTER}</script>",
        }
    )


def _styled(posters: Posters) -> dict[str, str]:
    """Return the change of the page that shows a poster before any script runs."""
    if not posters.style:
        return {}
    return {HEAD_END: f"  <style>\n{posters.style}\n    </style>\n  {HEAD_END}"}


def _attributes(up: Axis | None, heading: str, notes: Mapping[str, str]) -> str:
    """Return the attributes of an element for `--up`, a heading, and notes that no file holds."""
    values = {ATTRIBUTES.get(name, name): text for name, text in notes.items()}
    values |= {name: text for name, text in (("up", up), ("heading", heading)) if text}
    return "".join(f' {name}="{escaped(text)}"' for name, text in values.items())


def _manifest(title: str) -> bytes:
    """Return the web app manifest, with which browsers install the site."""
    icon = {
        "src": "icon.png",
        "sizes": f"{ICON}x{ICON}",
        "type": "image/png",
        "purpose": "any maskable",  # the image fills the icon up to its edges
    }
    manifest = {
        "name": html.unescape(title),
        "description": DESCRIPTION,
        "start_url": ".",
        "display": "fullscreen",
        "background_color": "#0d0f12",
        "icons": [icon],
    }
    return json.dumps(manifest, indent=1).encode()


def _service_worker(files: dict[str, bytes], name: str, version: str) -> bytes:
    """Return sw.js, which knows the version and the SHA-256 of the files that it keeps."""
    # no digests of pages and images, which hosts may change
    expected = {".": version, "index.html": version, **dict.fromkeys(UNVERIFIED, "")}
    kept = (*SCRIPTS, name)
    expected |= {file: hashlib.sha256(files[file]).hexdigest() for file in kept}
    changes = {
        'VERSION = ""': f'VERSION = "{version}"',
        "FILES = {}": f"FILES = {json.dumps(expected)}",
    }
    return _replaced(service_worker(), changes).encode()


def _folder_address(url: str) -> str:
    """Return a web address as that of a folder. Raises InputError if it is none."""
    try:
        parts = urlsplit(url)
        valid = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
    except ValueError:
        valid = False
    if not valid or re.search(r"[\s?#@]", url):
        raise InputError(f"{url!r} is not the address of a site, like https://me.example/garden/")
    return url.removesuffix("/index.html").rstrip("/") + "/"


def title_of(scene: Path) -> str:
    """Return the title that a .mgs stores, or the name of its capture, else the file's name."""
    if scene.suffix.lower() != ".mgs":
        return scene.stem
    notes = inspect_mgs(scene)["meta"]
    return str(notes.get("title") or notes.get("capture") or scene.stem)


def _is_page(file: Path) -> bool:
    """Return True if the file begins like an exported page."""
    begin = index_page().partition(TITLE)[0].encode()
    with open_input(file) as opened:
        return opened.read(len(begin)) == begin


def page_with(changes: dict[str, str]) -> str:
    """Return the viewer's page with other texts in place of some of its own."""
    return _replaced(index_page(), changes)


def _replaced(text: str, changes: dict[str, str]) -> str:
    for old, new in changes.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def _digest(content: bytes) -> str:
    """Return 8 hexadecimal digits that change with the content."""
    return hashlib.sha256(content).hexdigest()[:8]


def _icon(image: Image.Image) -> bytes:
    """Return the square middle of the poster as a PNG."""
    edge = (SIZE[0] - SIZE[1]) // 2
    square = image.crop((edge, 0, edge + SIZE[1], SIZE[1])).resize((ICON, ICON))
    return encoded(square, "png")
