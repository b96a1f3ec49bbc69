"""The web server of the viewer: what it serves and what not."""

import errno
import gzip
import http.client
import io
import os
import re
import socket
import sys
import threading
import time
from collections.abc import Iterator
from http.server import ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, quote, urlsplit

import pytest
import segno

from mobilegs.cli.main import main
from mobilegs.errors import InputError
from mobilegs.formats.ply import COLUMNS
from mobilegs.progress_display import printed_log
from mobilegs.up import Axis
from mobilegs.view.assets import script
from mobilegs.view.serve import SCENE, Handler, Server, own_address, serve


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server with a file of 3 MB, whose name must be quoted in an address."""
    scene = tmp_path_factory.mktemp("scenes") / "my garden & co.mgs"
    scene.write_bytes(bytes(range(256)) * 12_000)
    (scene.parent / "secret.mgs").write_bytes(b"not yours")
    with Server(scene) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


def get(
    server: Server, path: str, wishes: dict[str, str] | None = None
) -> tuple[int, dict[str, str], bytes]:
    """Return status, headers and body of an answer; the path is sent unchanged, dots included."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    connection.request("GET", path, headers=wishes or {})
    answer = connection.getresponse()
    found = answer.status, dict(answer.getheaders()), answer.read()
    connection.close()
    return found


def ply(kind: str, number: str) -> bytes:
    """Return the .ply header of a scene without Gaussians."""
    lines = ["ply", f"format {kind} 1.0", "element vertex 0"]
    lines += [f"property {number} {name}" for name in COLUMNS]
    return "\n".join([*lines, "end_header", ""]).encode()


def test_the_scene_is_served_unchanged(server: Server) -> None:
    status, headers, body = get(server, "/scene")
    assert status == 200 and body == server.scenes[SCENE].read_bytes()
    assert headers["Content-Length"] == str(len(body))


def test_many_visitors_who_come_together_all_get_the_scene(server: Server) -> None:
    visits = [
        socket.create_connection(("127.0.0.1", server.server_port), timeout=20) for _ in range(64)
    ]
    expected = server.scenes[SCENE].read_bytes()
    for visit in visits:
        visit.sendall(b"GET /scene HTTP/1.0\r\n\r\n")
    for number, visit in enumerate(visits):
        with visit:
            if number % 2:  # half of them leave before the end
                continue
            with visit.makefile("rb") as answer:
                assert answer.read().endswith(expected)


def test_names_of_other_sites_are_refused(server: Server) -> None:
    """A name of another site that resolves to this machine does not read the scene."""
    for host in ("evil.example", "evil.example:80", "", "127.0.0.1.evil.example", "[::1"):
        assert get(server, "/scene", {"Host": host})[0] == 403
    for host in ("localhost", "127.0.0.1:9", "192.168.0.7:8000", "[::1]:8000", "my-box.local"):
        assert get(server, "/scene", {"Host": host})[0] == 200


def test_more_connections_than_allowed_are_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mobilegs.view.serve.CONNECTIONS_MAX", 3)
    scene = tmp_path / "scene.mgs"
    scene.write_bytes(b"scene")
    with Server(scene) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        place = "127.0.0.1", server.server_port
        idle = [socket.create_connection(place, timeout=20) for _ in range(3)]
        with socket.create_connection(place, timeout=20) as late:
            assert late.recv(1) == b""
        for one in idle:
            one.close()
        end = time.monotonic() + 20
        while time.monotonic() < end:
            try:
                assert get(server, "/scene")[2] == b"scene"
                break
            except (ConnectionError, http.client.HTTPException):  # their threads end now
                time.sleep(0.05)
        else:
            pytest.fail("connections that ended were never free again")
        server.shutdown()


def test_a_server_without_descriptors_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def get_request(server: ThreadingHTTPServer) -> None:
        calls.append(1)
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    monkeypatch.setattr(ThreadingHTTPServer, "get_request", get_request)
    scene = tmp_path / "scene.mgs"
    scene.write_bytes(b"scene")
    with Server(scene) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with socket.create_connection(("127.0.0.1", server.server_port), timeout=20):
            time.sleep(0.5)
        server.shutdown()
    assert 1 <= len(calls) <= 6


def test_a_client_that_says_nothing_is_let_go(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Handler, "timeout", 0.2)
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=20) as connection:
        connection.sendall(b"GET /scene HT")
        assert connection.recv(1) == b""


def test_a_client_that_sends_a_byte_now_and_then_is_let_go(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Handler, "timeout", 0.5)
    begin = time.monotonic()
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=20) as connection:
        with pytest.raises(ConnectionError):
            while time.monotonic() < begin + 20:
                connection.sendall(b"G")
                time.sleep(0.1)
    assert time.monotonic() < begin + 10


def test_a_connection_is_kept_while_its_requests_come_in_time(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Handler, "timeout", 1.0)
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    connection.connect()
    own = connection.sock
    for _ in range(4):
        time.sleep(0.4)
        connection.request("GET", "/scene")
        assert len(connection.getresponse().read()) == 256 * 12_000
    assert connection.sock is own
    connection.close()


@pytest.mark.parametrize("path", ["/", "/?url=/scene", "/scene", "/viewer.js", "/gone", "//["])
def test_every_answer_has_the_headers_that_protect_it(server: Server, path: str) -> None:
    _, headers, _ = get(server, path)
    assert headers["X-Content-Type-Options"] == "nosniff"
    policy = headers["Content-Security-Policy"]
    for directive in ("default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'"):
        assert directive in policy.split("; ")
    [scripts] = re.findall(r"script-src ([^;]*);", policy)
    assert re.fullmatch(r"'self' 'sha256-[\w+/=]{44}' 'wasm-unsafe-eval'", scripts)


def test_head_requests_get_headers_only(server: Server) -> None:
    for path in ("/scene", "/?url=/scene", "/nothing"):
        connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
        connection.request("HEAD", path)
        answer = connection.getresponse()
        status, headers, _ = get(server, path)
        assert answer.status == status
        assert answer.getheader("Content-Length") == headers["Content-Length"]
        assert answer.read() == b""
        connection.close()


def test_a_malformed_address_is_refused(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=20) as connection:
        connection.sendall(b"GET http://[ HTTP/1.1\r\nHost: localhost\r\n\r\n")
        assert connection.recv(100).startswith(b"HTTP/1.1 400 ")
    assert get(server, "/scene")[0] == 200
    assert capsys.readouterr().err == ""


def test_truncating_a_scene_during_transfer_closes_the_connection(tmp_path: Path) -> None:
    scene = tmp_path / "a.mgs"
    scene.write_bytes(bytes(30 << 20))
    with Server(scene) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
        connection.request("GET", "/scene")
        answer = connection.getresponse()
        answer.read(1000)
        os.truncate(scene, 1 << 20)
        with pytest.raises(http.client.IncompleteRead):
            answer.read()
        connection.close()
        server.shutdown()


def test_a_browser_command_that_blocks_gets_the_page(tmp_path: Path, visited: list[int]) -> None:
    """Some commands end only when their browser does."""
    scene = tmp_path / "a.mgs"
    scene.write_bytes(b"scene")
    serve(scene, None, lan=False, port=0, browser=True)
    assert visited == [302]


@pytest.mark.usefixtures("visited")
def test_lan_prints_an_address_and_its_qr_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "a.mgs"
    scene.write_bytes(b"scene")
    monkeypatch.setattr("mobilegs.view.serve.own_address", lambda: "192.0.2.7")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    with printed_log():
        serve(scene, None, lan=True, port=0, browser=True)
    said = capsys.readouterr().out
    [address] = re.findall(r"in this network at (http://192\.0\.2\.7:\d+/\?url=/scene)", said)
    drawn = io.StringIO()
    segno.make(address, error="l").terminal(drawn, compact=True)
    assert drawn.getvalue() in said


@pytest.mark.parametrize(
    ("comment", "option", "sentence"),
    [
        ("", None, "up is -y, as usual: the file does not say (the key U or --up changes it)"),
        ("comment Vertical Axis: z\n", None, "up is z, as the file says"),
        ("comment Vertical Axis: z\n", "x", "&up=x"),
    ],
)
def test_view_says_which_way_is_up(
    comment: str,
    option: Axis | None,
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    scene = tmp_path / "a.ply"
    head = ply("binary_little_endian", "float")
    scene.write_bytes(head.replace(b"element", f"{comment}element".encode()))
    monkeypatch.setattr(Server, "serve_forever", lambda self: None)
    with printed_log():
        serve(scene, None, up=option, lan=False, port=0, browser=False)
    said = capsys.readouterr().out
    assert sentence in said
    assert ("up is" in said) == (option is None)


def test_the_root_redirects_to_the_scene(server: Server) -> None:
    status, headers, _ = get(server, "/")
    assert status == 302
    assert headers["Location"] == "/?url=/scene"
    assert server.address("host").endswith(headers["Location"])
    status, headers, body = get(server, headers["Location"])
    assert status == 200 and b"<mobile-gs linkable>" in body
    assert headers["Content-Type"].startswith("text/html")
    status, headers, _ = get(server, "/?bench=60,640x360&noui")
    assert status == 302
    assert headers["Location"] == "/?url=/scene&bench=60,640x360&noui"


def test_the_title_names_the_scenes(tmp_path: Path) -> None:
    files = [tmp_path / "a & b" / "scene.mgs", tmp_path / "plain.ply"]
    for file in files:
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(b"x")
    with Server(*files) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        _, _, body = get(server, server.path)
        server.shutdown()
    title = f"a &amp; b/scene.mgs | {tmp_path.name}/plain.ply"
    assert f"<title>{title}</title>" in body.decode()


def test_the_script_of_the_page_is_served(server: Server) -> None:
    _, _, page = get(server, "/?url=/scene")
    found = re.search(rb'src="(/viewer\.js\?\w{16})"', page)
    assert found and page.count(found[1]) == 1
    status, headers, body = get(server, found[1].decode())
    assert status == 200 and body.decode() == script("viewer.js")
    assert "immutable" in headers["Cache-Control"]
    for address in ("/viewer.js", "/viewer.js?0123456789abcdef"):
        status, headers, other = get(server, address)
        assert status == 200 and other == body and headers["Cache-Control"] == "no-cache"
    assert "javascript" in headers["Content-Type"] and "Content-Encoding" not in headers
    _, headers, packed = get(server, "/viewer.js", {"Accept-Encoding": "br, gzip"})
    assert headers["Content-Encoding"] == "gzip" and gzip.decompress(packed) == body
    assert len(packed) < 64_000


def test_nothing_else_is_served(server: Server) -> None:
    paths = ["/scene/secret.mgs", "/scene/", "/other", "/serve.py", "/dist/../serve.py"]
    paths += ["/dist/%2e%2e/serve.py", "/../../pyproject.toml", "//etc/passwd", "/dist/", "/dist"]
    paths += ["/dist/viewer.js", "/viewer.js/", "/dist/nul\\..\\..\\serve.py"]
    assert {path: get(server, path)[0] for path in paths} == dict.fromkeys(paths, 404)


def test_a_deleted_scene_is_not_found(tmp_path: Path) -> None:
    scene = tmp_path / "a.mgs"
    scene.write_bytes(b"x")
    with Server(scene) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        scene.unlink()
        assert get(server, "/scene")[0] == 404
        server.shutdown()


@pytest.mark.parametrize("name", ["a & b (1).mgs", "100% a+b,c 'it's#1 ä?.mgs"])
def test_two_scenes_are_compared(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"first")
    (tmp_path / "b.ply").write_bytes(b"second")
    with Server(tmp_path / name, tmp_path / "b.ply") as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = get(server, "/")[1]["Location"]
        # as the page reads its own address
        wishes = parse_qs(urlsplit(page).query)
        [first], [second] = wishes["url"], wishes["compare"]
        assert first == f"/scene/{quote(name)}" and second == "/other/b.ply"
        assert get(server, first)[2] == b"first" and get(server, second)[2] == b"second"
        assert get(server, first.replace("scene", "other", 1))[0] == 404
        server.shutdown()


def test_it_listens_only_on_this_machine_by_default(server: Server) -> None:
    assert server.server_address[0] == "127.0.0.1"
    assert own_address() is None or "." in str(own_address())


def test_a_port_in_use_is_reported(server: Server, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"cannot listen on 127.0.0.1:{server.server_port}"):
        Server(server.scenes[SCENE], port=server.server_port)
    with pytest.raises(InputError, match="there is no such file"):
        Server(tmp_path / "gone.mgs")


def test_view_refuses_bad_options_with_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", str(tmp_path / "gone.mgs"), "--port", "70000"]) == 2
    assert "gone.mgs does not exist" in capsys.readouterr().err
    (tmp_path / "a.mgs").write_bytes(b"x")
    assert main(["view", str(tmp_path / "a.mgs"), "--port", "70000"]) == 2
    assert "between 0 and 65535" in capsys.readouterr().err


def test_files_that_are_not_scenes_are_refused(tmp_path: Path) -> None:
    mesh = b"ply\nformat ascii 1.0\nelement face 1\nend_header\n"
    cases = {
        "empty.mgs": (b"", "is empty"),
        "notes.txt": (b"text", "not a scene"),
        "text.ply": (ply("ascii", "float"), "not a .ply that the web viewer"),
        "big.ply": (ply("binary_big_endian", "float"), "not a .ply that the web viewer"),
        "double.ply": (ply("binary_little_endian", "double"), "not a .ply that the web viewer"),
        "mesh.ply": (mesh, "not a .ply that the web viewer"),
    }
    for name, (content, sentence) in cases.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=sentence):
            serve(tmp_path / name, None, lan=False, port=0, browser=False)
    (tmp_path / "folder.mgs").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        serve(tmp_path / "folder.mgs", None, lan=False, port=0, browser=False)
