"""Sources at addresses are fetched once for each content, and their secrets are in no file."""

import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import fsspec
import pytest

from mobilegs.batch.engine import Node
from mobilegs.batch.fetch import (
    fetch,
    is_address,
    shown_address,
    validate_address,
    without_secrets,
)
from mobilegs.batch.row_folder import RowFolder
from mobilegs.batch.rows import Row, read_list
from mobilegs.batch.run import BatchOptions, open_folder, run_batch
from mobilegs.batch.task import Outcome, Task
from mobilegs.batch.worker import _run
from mobilegs.errors import InputError


@pytest.fixture
def bucket() -> Iterator[fsspec.AbstractFileSystem]:
    """The file system `memory://`, with a folder of two photos."""
    files = fsspec.filesystem("memory")
    files.pipe("/bucket/garden/a.jpg", b"one")
    files.pipe("/bucket/garden/sub/b.jpg", b"two")
    yield files
    files.rm("/bucket", recursive=True)


def test_a_folder_and_a_file_are_fetched_with_their_names(
    bucket: fsspec.AbstractFileSystem, tmp_path: Path
) -> None:
    path = fetch("memory://bucket/garden/", tmp_path)
    assert path.name == "garden"
    found = {str(file.relative_to(path)): file.read_bytes() for file in path.rglob("*.jpg")}
    assert found == {"a.jpg": b"one", str(Path("sub/b.jpg")): b"two"}
    path = fetch("memory://bucket/garden/a.jpg", tmp_path)
    assert path.name == "a.jpg" and path.read_bytes() == b"one"


def test_the_same_content_is_fetched_once_and_a_change_again(
    bucket: fsspec.AbstractFileSystem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fetched = []
    get = type(bucket).get_file
    monkeypatch.setattr(
        type(bucket), "get_file", lambda *words, **more: (fetched.append(1), get(*words, **more))
    )
    first = fetch("memory://bucket/garden", tmp_path)
    assert fetch("memory://bucket/garden", tmp_path) == first and len(fetched) == 2
    bucket.pipe("/bucket/garden/a.jpg", b"three")
    second = fetch("memory://bucket/garden", tmp_path)
    assert second != first and (second / "a.jpg").read_bytes() == b"three"
    assert (first / "a.jpg").read_bytes() == b"one"  # a run that uses it is not disturbed


def test_a_fetch_that_fails_leaves_nothing_in_its_place(
    bucket: fsspec.AbstractFileSystem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*words: object, **more: object) -> None:
        raise OSError("the network is gone")

    with monkeypatch.context() as patch:
        patch.setattr(type(bucket), "get_file", fails)
        with pytest.raises(OSError, match="the network is gone"):
            fetch("memory://bucket/garden", tmp_path)
    assert (fetch("memory://bucket/garden", tmp_path) / "a.jpg").read_bytes() == b"one"
    with pytest.raises(InputError, match="there is nothing at memory://bucket/nothing"):
        fetch("memory://bucket/nothing", tmp_path)


def test_paths_are_no_addresses() -> None:
    for path in ("/a/b", "file:///a", "FILE:///a"):
        assert not is_address(path)
    assert is_address("s3://a/b")


@pytest.mark.parametrize(
    ("address", "shown"),
    [
        ("s3://captures/hall", "s3://captures/hall"),
        ("s3://captures/a@2x/b", "s3://captures/a@2x/b"),
        ("https://host:8443/a.ply", "https://host:8443/a.ply"),
        ("http://[::1]:80/a@b", "http://[::1]:80/a@b"),
        ("zip://a.ply::https://host/x.zip", "zip://a.ply::https://host/x.zip"),
        ("/photos/a?b#c@d", "/photos/a?b#c@d"),
        ("https://SECRET@host/a.ply", "https://host/a.ply?***"),
        ("https://user:SECRET@host/a.ply", "https://host/a.ply?***"),
        ("https://user:SE@CRET@host/a.ply", "https://host/a.ply?***"),
        ("https://user:SE/CR?ET@host/a.ply", "https://host/a.ply?***"),
        ("https://host/a.ply?X-Amz-Signature=SECRET", "https://host/a.ply?***"),
        ("https://host/a.ply?a=b c::SECRET", "https://host/a.ply?***"),
        ("https://host/a.ply#SECRET", "https://host/a.ply?***"),
        ("zip://a.ply::https://u:SECRET@host/x.zip?SECRET", "zip://a.ply::https://host/x.zip?***"),
    ],
)
def test_what_is_shown_of_an_address_has_no_secrets(address: str, shown: str) -> None:
    public, mark, digest = shown_address(address).partition("?***")
    assert public + mark == shown and len(digest) == (8 if mark else 0)
    assert shown_address(shown_address(address)) == shown_address(address)
    if " " not in address:
        said = f"'{shown_address(address)}' and {shown_address(address)}: no"
        assert without_secrets(f"'{address}' and {address}: no") == said


def test_addresses_of_other_content_are_shown_apart() -> None:
    other = ("https://u:1@h/a", "https://v:1@h/a", "https://u:1@h/a?b", "https://u:1@h/a#b")
    assert len({shown_address(address) for address in other}) == len(other)
    assert shown_address("https://u:1@h/a") == shown_address("https://u:2@h/a")  # a new password


class Served(BaseHTTPRequestHandler):
    """A server of one file, for those who have the token or the password."""

    def do_HEAD(self) -> None:
        allowed = "token=good" in self.path or self.headers.get("Authorization") is not None
        self.send_response(404 if "none" in self.path else 200 if allowed else 403)
        self.send_header("Content-Length", "5")
        self.end_headers()

    def do_GET(self) -> None:
        self.do_HEAD()
        self.wfile.write(b"hello")

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[str]:
    """Yield the host and port of a server on this machine."""
    pytest.importorskip("aiohttp", reason="needs aiohttp (the extra batch)")
    served = ThreadingHTTPServer(("127.0.0.1", 0), Served)
    thread = threading.Thread(target=served.serve_forever)
    thread.start()
    yield f"127.0.0.1:{served.server_port}"
    served.shutdown()
    thread.join()
    served.server_close()


class InlineEngine:
    """An engine that runs each task at once, in this process."""

    name = "inline"

    def __init__(self) -> None:
        self._ended: list[tuple[Task, Outcome]] = []

    def nodes(self) -> list[Node]:
        return [Node("local", 1, 0)]

    def accepts(self, task: Task) -> bool:
        return True

    def submit(self, task: Task) -> None:
        self._ended.append((task, Outcome(*_run(task, RowFolder(Path(task.folder))))))

    def ended(self, seconds: float) -> list[tuple[Task, Outcome]]:
        ended, self._ended = self._ended, []
        return ended

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


def test_no_file_and_no_line_of_a_batch_has_the_secrets_of_its_addresses(
    server: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    sources = [
        f"http://{server}/denied.ply?token=SECRET",
        f"http://{server}/fine.txt?token=good-SECRET#SECRET",
        f"http://user:SECRET@{server}/open.txt",
        "http://user:SECRET@127.0.0.1:1/gone.ply?sig=SECRET",
        f"http://{server}/none.ply?SECRET.ply",
    ]
    (tmp_path / "list.csv").write_text("\n".join(["source", *sources]), "utf-8")
    rows = read_list(tmp_path / "list.csv", {})
    output, said = tmp_path / "out", []
    options = BatchOptions(output, cores=1, retries=1)
    entries = run_batch(rows, options, InlineEngine, said.append, said.append)
    whys = ["may not be read: ClientResponseError, status 403", "nor a scene", "nor a scene"]
    whys += ["cannot be fetched: ClientConnectorError", "there is nothing at"]
    for entry, why in zip(entries, whys, strict=True):
        assert entry.state == "failed" and why in entry.error, entry
    assert [entry.name for entry in entries] == ["denied", "fine", "open", "gone", "none"]
    assert {path.name for path in (output / "cache").rglob("*.txt")} == {"fine.txt", "open.txt"}
    heard = repr(capfd.readouterr()) + repr(said) + repr(entries)
    for path in output.rglob("*"):
        inside = str(path.relative_to(output))
        heard += inside + (path.read_text("utf-8") if path.is_file() else "")
    assert "SECRET" not in heard
    assert f"http://{server}/denied.ply?***" in heard


def test_a_row_continues_with_another_password_and_not_with_another_query(tmp_path: Path) -> None:
    def rows(address: str) -> list[Row]:
        return [Row(1, "one", address, {}, [])]

    options = BatchOptions(tmp_path, resume=True)
    folder = RowFolder(tmp_path / "one")
    folder.create(shown_address("https://u:SECRET@host/a.ply?id=1"), {}, [])
    folder.capture.mkdir()
    open_folder(options, rows("https://u:OTHER@host/a.ply?id=1"))
    with pytest.raises(InputError, match="was begun with the source https://host/a") as caught:
        open_folder(options, rows("https://u:SECRET@host/a.ply?id=2-SECRET"))
    assert "SECRET" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("list.csv", "name,source\nhttps://u:SECRET@h/a,garden\n"),
        ("list.csv", "https://u:SECRET@h/a?SECRET\nhttps://u:SECRET@h/b\n"),
        ("list.csv", "source\na,https://u:SECRET@h/a\n"),
        ("list.csv", "source\ns4://h/a b?x=SECRET y\n"),
        ("list.jsonl", '{"source": "memory://a.ply", "capture": "https://h/a?SECRET"}\n'),
    ],
)
def test_faults_of_a_list_have_no_secrets(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text, "utf-8")
    with pytest.raises(InputError) as caught:
        read_list(tmp_path / name, {})
    assert "SECRET" not in str(caught.value)


def test_a_web_address_without_its_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(protocol: str) -> None:
        raise ImportError("no aiohttp")

    monkeypatch.setattr(fsspec, "get_filesystem_class", absent)
    with pytest.raises(InputError, match=r"pip install 'mobilegs\[batch\]'"):
        validate_address("https://host/a.ply")
    with pytest.raises(InputError, match="cannot be read here: no aiohttp"):
        validate_address("s3://bucket/a")
