"""Sources at addresses are fetched once for each content."""

from collections.abc import Iterator
from pathlib import Path

import fsspec
import pytest

from mobilegs.batch.fetch import fetch, is_address
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
    assert not is_address("/a/b") and not is_address("file:///a") and is_address("s3://a/b")
