"""A scene with its viewer, for any host or none: one HTML file, or a folder that installs."""

import base64
import hashlib
import html
import io
import json
import re
from pathlib import Path
from urllib.parse import urlsplit

import torch
from PIL import Image

from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera, look_at
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene
from mobilegs.view.bundle import (
    SCRIPT,
    TITLE,
    WEB,
    element_script,
    linked,
    shown,
    viewer_script,
)
from mobilegs.view.serve import KINDS, refuse_unreadable

POSTER = (1200, 630)  # pixels; what services that preview links ask for
ICON = 512
# files of a folder that was written here, and what is in them: the first one comes first
MADE = "A scene in 3D, exported by mobilegs"
MARKS = {"manifest.webmanifest": MADE, "sw.js": "Keeps an exported site on the device"}
COSMETIC = ("manifest.webmanifest", "poster.jpg", "icon.png")
HTML_MAX = 400_000_000  # bytes of a scene: strings of browsers end at 2^29
# of index.html, replaced by what an exported page has in their place
LINK = '<link rel="icon" href="data:," />'
ELEMENT = "<mobile-gs></mobile-gs>"
LINK_ICON = '<link rel="icon" href="icon.png" />'
# not before there is something to see: what is kept comes once more
REGISTER = """<script>
      const keep = () => navigator.serviceWorker?.register("sw.js").catch(() => {});
      const scene = document.querySelector("mobile-gs");
      for (const name of ["load", "error"]) scene.addEventListener(name, keep, { once: true });
    </script>"""
PREVIEW = """    <meta property="og:url" content="{}" />
    <meta property="og:type" content="website" />
    <meta name="twitter:card" content="summary_large_image" />
"""


def export_html(scene: Path, output: Path, *, title: str) -> int:
    """Write one HTML file that holds viewer and scene and needs no server; returns its bytes.

    Raises InputError if there is a file that something else made.
    """
    refuse_unreadable(scene)
    if output.is_file() and not _is_page(output):
        raise InputError(f"{output} is no exported page, and would be lost: give another name")
    if scene.stat().st_size > HTML_MAX:
        raise InputError(
            f"{scene} is larger than the {HTML_MAX // 10**6} MB that browsers take in a page: "
            "use --to site"
        )
    image = base64.b64encode(_jpeg(poster_of(scene))).decode()
    data = base64.b64encode(scene.read_bytes()).decode()
    page = _page(
        {
            TITLE: f"<title>{shown(title)}</title>",
            ELEMENT: f'<mobile-gs poster="data:image/jpeg;base64,{image}"></mobile-gs>',
            SCRIPT: f'<script type="application/octet-stream" id="scene">{data}</script>\n'
            f'    <script type="module">\n{viewer_script()}</script>',
        }
    )
    atomic_write(output, page)
    return len(page.encode())


def export_site(scene: Path, output: Path, *, title: str, url: str = "") -> int:
    """Write a folder for any web host; phones can install it and open it offline.

    `url` is where it will lie: what previews links wants the whole address of the picture. Returns
    the bytes in it. InputError if there is a folder that something else made, or for a `url`
    that is no web address.
    """
    refuse_unreadable(scene)
    if url:
        url = _folder_address(url)
    kept = output / "sw.js"
    if output.exists() and not any(
        (output / file).is_file() and mark.encode() in (output / file).read_bytes()
        for file, mark in MARKS.items()
    ):
        if not output.is_dir() or any(output.iterdir()):
            raise InputError(f"{output} holds something else: give a new folder")
    picture = poster_of(scene)
    icon = io.BytesIO()
    edge = (POSTER[0] - POSTER[1]) // 2
    square = picture.crop((edge, 0, edge + POSTER[1], POSTER[1])).resize((ICON, ICON))
    square.save(icon, format="PNG")
    safe, name = shown(title), f"scene{scene.suffix.lower()}"
    content, poster = scene.read_bytes(), _jpeg(picture)
    page = _page(
        {
            TITLE: f"<title>{safe}</title>\n"
            f'    <meta property="og:title" content="{safe}" />\n'
            f'    <meta property="og:image" content="{html.escape(url)}poster.jpg" />\n'
            f"{PREVIEW.format(html.escape(url)) if url else ''}"
            '    <link rel="manifest" href="manifest.webmanifest" />',
            LINK: f'{LINK_ICON}\n    <link rel="apple-touch-icon" href="icon.png" />',
            # their addresses change with them: browsers may have others from a visit before
            ELEMENT: f'<mobile-gs src="{name}?{_mark(content)}" '
            f'poster="poster.jpg?{_mark(poster)}"></mobile-gs>',
            SCRIPT: f"{linked('viewer.js')}\n    {REGISTER}",
        }
    )
    manifest = {
        "name": html.unescape(safe),
        "description": MADE,
        "start_url": ".",
        "display": "fullscreen",
        "background_color": "#0d0f12",
        "icons": [
            {
                "src": "icon.png",
                "sizes": f"{ICON}x{ICON}",
                "type": "image/png",
                "purpose": "any maskable",  # it is a picture up to its edges
            }
        ],
    }
    files = {
        "manifest.webmanifest": json.dumps(manifest, indent=1).encode(),
        "poster.jpg": poster,
        "icon.png": icon.getvalue(),
        "viewer.js": viewer_script().encode(),
        "mobile-gs.js": element_script().encode(),
        name: content,
    }
    version = hashlib.sha256(page.encode() + b"".join(files.values())).hexdigest()[:16]
    page = _replaced(
        page, {LINK_ICON: f'<meta name="version" content="{version}" />\n    {LINK_ICON}'}
    )
    # hosts add to pages and repack pictures
    wanted = {".": version, "index.html": version, **dict.fromkeys(COSMETIC, "")}
    wanted |= {file: hashlib.sha256(files[file]).hexdigest() for file in ("viewer.js", name)}
    changes = {
        'VERSION = ""': f'VERSION = "{version}"',
        "FILES = {}": f"FILES = {json.dumps(wanted)}",
    }
    text = _replaced((WEB / "offline.js").read_text(), changes)
    before = kept.read_text() if kept.is_file() else ""
    # what tells visitors that there is something new comes last
    files |= {"index.html": page.encode(), "sw.js": text.encode()}
    for file, data in files.items():
        atomic_write(output / file, data)
    for old in (f"scene{kind}" for kind in KINDS):
        if old != name and json.dumps(old) in before:
            (output / old).unlink(missing_ok=True)
    return sum(map(len, files.values()))


def _folder_address(url: str) -> str:
    """A web address as that of a folder."""
    try:
        parts = urlsplit(url)
        sound = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
    except ValueError:
        sound = False
    if not sound or re.search(r"[\s?#@]", url):
        raise InputError(f"{url!r} is no address of a site, like https://me.example/garden/")
    return url.removesuffix("/index.html").rstrip("/") + "/"


def title_of(scene: Path) -> str:
    """The capture that a .mgs says it is of, or else the file's name."""
    if scene.suffix.lower() != ".mgs":
        return scene.stem
    return str(inspect_mgs(scene)["meta"].get("capture") or scene.stem)


@torch.inference_mode()
def poster_of(path: Path) -> Image.Image:
    """What a visitor sees first, 1200 x 630: from a training camera, or from aside.

    Reads the whole file. InputError for a scene that the web viewer does not show.
    """
    if path.suffix.lower() == ".mgs":
        coded = read_mgs(path)
        scene, views = coded.decode(), coded.views or []
    else:
        scene, views = open_scene(path, torch.device("cpu")), []
    if scene.network is not None:
        raise InputError(
            f"{path} asks a network for every Gaussian in every frame, which no viewer does: "
            "train with --set student.view.kind=fitted student.view.fraction=0.35"
        )
    if scene.weighting.name == "two_pass":
        raise InputError(f"{path} has the weighting 'two_pass', which no viewer draws")
    camera = views[0] if views else _aside(scene)
    width, height = POSTER
    # as pose.js does: between all of the camera's field and only what fills the picture
    focal = float(
        (camera.K[0, 0] * width / camera.width * camera.K[1, 1] * height / camera.height) ** 0.5
    )
    k = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    drawn = scene.render(Camera(camera.viewmat, k, width, height, scene.near))
    return Image.fromarray(to_bytes(drawn.image).numpy())


def _aside(scene: Scene) -> Camera:
    """From where pose.js looks at a scene without cameras."""
    if not len(scene.gaussians):
        raise InputError("the scene has no Gaussians: there is nothing to show")
    shares = torch.tensor([0.25, 0.5, 0.75])
    low, middle, high = torch.quantile(scene.gaussians.means[:1_000_000], shares, dim=0)
    size = float((high - low).max()) or 1.0
    eye = middle + 2 * size * torch.tensor([0.0, -0.3, -1.0])
    viewmat = look_at(eye, middle, torch.tensor([0.0, -1.0, 0.0]))
    return Camera(viewmat, torch.tensor([[1.0, 0, 0.5], [0, 1, 0.5], [0, 0, 1]]), 1, 1)


def _is_page(file: Path) -> bool:
    """Whether an exported page is there: it begins as all of them do."""
    begin = (WEB / "index.html").read_bytes().partition(TITLE.encode())[0]
    with file.open("rb") as opened:
        return opened.read(len(begin)) == begin


def _page(changes: dict[str, str]) -> str:
    return _replaced((WEB / "index.html").read_text(), changes)


def _replaced(text: str, changes: dict[str, str]) -> str:
    for old, new in changes.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def _mark(content: bytes) -> str:
    """What changes with a file."""
    return hashlib.sha256(content).hexdigest()[:8]


def _jpeg(picture: Image.Image) -> bytes:
    out = io.BytesIO()
    picture.save(out, format="JPEG", quality=80, optimize=True)
    return out.getvalue()
