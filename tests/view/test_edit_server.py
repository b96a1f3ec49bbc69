"""The editor's server: whom it answers, and what a page can make it write."""

import base64
import http.client
import json
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs, read_mgs
from mobilegs.mgs.quantized_scene import scenes_equal
from mobilegs.view.assets import editor_script, script
from mobilegs.view.edit_server import SETTINGS_MAX, EditServer, edit_from_page
from mobilegs.viewpoints.framing import parsed_start
from tests.support.viewer_page import MGS

JSON = "application/json"
COUNT = len(decode_mgs(MGS))


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.mgs"
    path.write_bytes(MGS)
    return path


@pytest.fixture
def server(scene: Path) -> Iterator[EditServer]:
    with EditServer(scene, None, lambda: ([], "")) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


def ask(
    server: EditServer,
    method: str,
    path: str,
    body: bytes | None = None,
    **headers: str | None,
) -> tuple[int, dict[str, str], bytes]:
    """Send a request like the page's, with other `headers`; None leaves one out."""
    host = f"127.0.0.1:{server.server_port}"
    own: dict[str, str | None] = {"Host": host}
    if method == "POST":
        own |= {"Origin": f"http://{host}", "Content-Type": JSON}
        own["Content-Length"] = str(len(body or b""))
    given = own | {name.replace("_", "-"): value for name, value in headers.items()}
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in given.items():
        if value is not None:
            connection.putheader(name, value)
    connection.endheaders(body)
    answer = connection.getresponse()
    found = answer.status, dict(answer.getheaders()), answer.read()
    connection.close()
    return found


def save(server: EditServer, posted: Any, **headers: str | None) -> tuple[int, Any]:
    body = json.dumps(posted).encode()
    status, found, text = ask(server, "POST", f"{server.path}save", body, **headers)
    return status, json.loads(text) if found.get("Content-Type") == JSON else text


def bits(rows: list[int], count: int = COUNT) -> str:
    mask = np.zeros(count, bool)
    mask[rows] = True
    return base64.b64encode(np.packbits(mask, bitorder="little").tobytes()).decode()


def test_the_page_and_its_files_are_served_under_the_token(server: EditServer) -> None:
    assert len(server.token) >= 32
    status, headers, body = ask(server, "GET", server.path)
    assert status == 200 and b'src="edit.js"' in body and b'<mobile-gs src="scene"' in body
    assert headers["Referrer-Policy"] == "no-referrer"
    policy = headers["Content-Security-Policy"]
    assert "frame-ancestors 'none'" in policy and "script-src 'self' 'sha256-" in policy
    assert ask(server, "GET", f"{server.path}scene")[2] == MGS
    assert ask(server, "GET", f"{server.path}viewer.js?1")[2].decode() == script("viewer.js")
    assert ask(server, "GET", f"{server.path}edit.js")[2].decode() == editor_script()
    assert ask(server, "GET", f"{server.path}webgl.js")[0] == 200
    found = json.loads(ask(server, "GET", f"{server.path}notes")[2])
    assert found == {"notes": decode_mgs(MGS).meta, "count": COUNT}


def test_what_cameras_saw_is_served(server: EditServer) -> None:
    _, headers, body = ask(server, "GET", f"{server.path}cameras")
    total, *seen = np.frombuffer(body, "<u2").tolist()
    assert total == len(decode_mgs(MGS).views) and len(seen) == COUNT and max(seen) <= total
    assert "cameras of the file" in headers["X-Cameras"]


def test_a_scene_without_cameras_says_so(tmp_path: Path) -> None:
    path = tmp_path / "scene.mgs"
    path.write_bytes(encode_mgs(replace(decode_mgs(MGS), views=[])))
    with EditServer(path, None, lambda: ([], "")) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        status, _, body = ask(server, "GET", f"{server.path}cameras")
        server.shutdown()
    assert status == 404 and "--capture" in json.loads(body)["error"]


def test_nothing_is_served_without_the_token(server: EditServer) -> None:
    paths = ["/", "/scene", "/viewer.js", "/wrong/", "/wrong/scene", "//", "/?url=/scene"]
    for path in paths:
        for method in ("GET", "HEAD", "POST"):
            assert ask(server, method, path)[0] == 404, path
    assert ask(server, "GET", f"{server.path}../scene.mgs")[0] == 404
    assert ask(server, "GET", f"{server.path}other")[0] == 404
    assert ask(server, "GET", server.path[:-2] + "/")[0] == 404


def test_other_hosts_and_origins_are_refused(server: EditServer) -> None:
    """A name of another site that resolves to this machine is not this machine."""
    for host in ("evil.example", "evil.example:80", "", None):
        assert ask(server, "GET", server.path, Host=host)[0] == 403, host
        assert save(server, {"title": "A"}, Host=host)[0] == 403, host
    local = f"127.0.0.1:{server.server_port}"
    others = (None, "null", "http://evil.example", f"https://{local}", "http://127.0.0.1:1")
    for origin in others:
        assert save(server, {"title": "A"}, Origin=origin)[0] == 403, origin
    assert not server.saved


def test_other_posts_are_refused(server: EditServer) -> None:
    assert save(server, {}, Content_Type="text/plain")[0] == 415
    assert save(server, {}, Content_Length=None)[0] == 411
    assert save(server, {}, Content_Length="-1")[0] == 411
    assert save(server, {}, Transfer_Encoding="chunked")[0] == 411
    assert save(server, {}, Content_Length=str(SETTINGS_MAX + COUNT))[0] == 413
    assert save(server, {}, Content_Length="9" * 5000)[0] == 413
    assert ask(server, "POST", f"{server.path}scene", b"{}")[0] == 404
    assert ask(server, "POST", f"{server.path}save", b"{")[0] == 400
    assert ask(server, "POST", f"{server.path}save", b"[" * 100_000)[0] == 400
    for method in ("PUT", "DELETE", "OPTIONS"):
        assert ask(server, method, f"{server.path}save")[0] == 501
    assert not server.saved


def test_saving_writes_new_files(server: EditServer, scene: Path) -> None:
    status, found = save(server, {"title": " A garden ", "removed": bits([3, 5, COUNT - 1])})
    assert status == 200 and found["file"] == "scene-edited.mgs"
    assert found["lines"][0] == "3 removed: selected"
    status, found = save(server, {"credit": "me"})
    assert status == 200 and found["file"] == "scene-edited-2.mgs"
    whole, edited = decode_mgs(MGS), read_mgs(scene.with_name("scene-edited.mgs"))
    rows = np.setdiff1d(np.arange(COUNT), [3, 5, COUNT - 1])
    kept = whole.select(torch.from_numpy(rows))
    expected = replace(kept, meta=whole.meta | {"title": "A garden"})
    assert scenes_equal(edited, replace(expected, lod_sizes=edited.lod_sizes))
    assert scene.read_bytes() == MGS
    assert server.saved == [
        scene.with_name(found) for found in ("scene-edited.mgs", "scene-edited-2.mgs")
    ]


def test_the_output_is_the_servers_choice(scene: Path, tmp_path: Path) -> None:
    output = tmp_path / "mine.mgs"
    with EditServer(scene, output, lambda: ([], "")) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for name in ("output", "path/../x", "file"):
            assert save(server, {"title": "A", name: "/tmp/evil.mgs"})[0] == 400
        assert save(server, {"title": "A"})[1]["file"] == "mine.mgs"
        status, found = save(server, {"title": "B"})
        assert status == 400 and "overwrites nothing" in found["error"]
        server.shutdown()
    with pytest.raises(InputError, match="overwrites nothing"):
        EditServer(scene, output, lambda: ([], ""))


def test_all_settings_become_notes() -> None:
    posted = {
        "title": "A",
        "credit": "",
        "up": [0, 0, 2],
        "start": [1, 2, 3, 0, 0, 0.5, 0.4, 0.3],
        "start_portrait": None,
        "floor": [0, 2, 0, 3],
        "annotations": [{"at": [1, 2, 3], "text": "b"}],
        "path": [[0, 0, 1, 0, 0, 0], [0, 1, 1, 0, 0, 0]],
        "free": True,
    }
    edit = edit_from_page(posted, COUNT)
    assert edit.rows is None and not edit.removes
    assert edit.notes == {
        "title": "A",
        "credit": "",
        "up": "0.000000 0.000000 1.000000",
        "start": "1 2 3 0 0 0.5 0.4 0.3",
        "start_portrait": "",
        "floor": "0 1 0 1.5",
        "annotations": '[{"at":[1.0,2.0,3.0],"text":"b"}]',
        "path": "0 0 1 0 0 0;0 1 1 0 0 0",
        "limits": "none",
    }
    tiny = {"floor": [1, 1e-320, 0, -1.23456e-8], "start": [1, 1e-9, 0, 0, 0, 1e-20, 1, 1]}
    noted = edit_from_page(tiny, COUNT).notes
    assert noted["floor"] == "1 0 0 -0.000000012346"  # as many decimals as readers take
    assert parsed_start(noted["start"]) is not None
    assert edit_from_page({"path": [], "annotations": []}, COUNT).notes == {
        "path": "",
        "annotations": "",
    }


@pytest.mark.parametrize(
    "posted",
    [
        None,
        [],
        {"other": 1},
        {"title": 3},
        {"title": "a\nb"},
        {"up": [0, 0, 0]},
        {"up": [0, 0]},
        {"up": [0, 0, True]},
        {"up": [0, 0, 1e300]},
        {"up": [0, 0, float("nan")]},
        {"start": [0] * 8},
        {"start": [1, 0, 0, 0, 0, 0, 0, 1]},
        {"up": [0, 1e-320, 0]},
        {"start": [1, 0, 0, 1, 1e-320, 0, 1, 1]},
        {"start": [1, 0, 0, 0, 0, 0, 1e-320, 1]},
        {"floor": [0, 0, 0, 1]},
        {"floor": [1e-320, 0, 0, 1]},
        {"floor": [1e-8, 0, 0, 1e11]},
        {"path": [[0, 0, 0, 1e-320, 0, 0], [0, 1, 1, 0, 0, 0]]},
        {"annotations": "[]"},
        {"path": [[0] * 6]},
        {"removed": 3},
        {"removed": ""},
        {"removed": "%%%"},
        {"removed": bits([1], COUNT + 64)},
        {"removed": base64.b64encode(b"\xff" * ((COUNT + 7) // 8)).decode() + "AA"},
    ],
)
def test_other_settings_are_refused(posted: Any) -> None:
    with pytest.raises(InputError):
        edit_from_page(posted, COUNT)


def test_edit_opens_the_browser_at_the_secret_address(
    scene: Path, visited: list[int], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["edit", str(scene)]) == 0
    assert visited == [200]
    assert "can be edited at http://127.0.0.1:" in capsys.readouterr().out
    assert main(["edit", str(scene), "--capture", "missing"]) == 2
    assert "missing does not exist" in capsys.readouterr().err


def test_an_edit_without_a_gaussian_left_is_refused(server: EditServer) -> None:
    status, found = save(server, {"removed": bits(list(range(COUNT)))})
    assert status == 400 and "no Gaussian of" in found["error"]
    assert not server.saved
