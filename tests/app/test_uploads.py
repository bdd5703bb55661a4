"""What is uploaded: kept whole under a harmless name, or refused with nothing left."""

import asyncio
import errno
import socket
import time
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path

import pytest
from app_server import Bench
from hypothesis import given
from hypothesis import strategies as st

from martensite.app import uploads
from martensite.app.messages import Refusal
from martensite.app.uploads import UploadFolder, clean_name
from martensite.base.errors import DataError

NAMES = (
    "../../etc/passwd",
    "C:\\x\\y.csv",
    "/abs/path.csv",
    "a\0b.csv",
    "x" * 4000 + ".csv",
    "𝒳" * 200 + ".csv",
    "‮vsc.exe",
    "..",
    ".",
    "   ",
    "con.txt",
    "NUL",
    "com1.csv",
    ".bashrc",
    "a/../../b",
    "a\nb.csv",
    "ﬁle／..／x",
    "~root",
    "$(reboot).csv",
    "-rf",
    "x.csv.",
    "%2e%2e%2f",
)


def kept(bench: Bench) -> set[str]:
    """All that lies in the folder of the bench, with what is beside it."""
    return {str(path) for path in bench.folder.parent.rglob("*")}


def resident(pid: int) -> float:
    """Memory that a process holds [MB]."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(text.partition("VmRSS:")[2].split()[0]) / 1024


def chunks(count: int, size: int = 2**20) -> Iterator[bytes]:
    yield from (bytes(size) for _ in range(count))


async def streamed(parts: list[bytes]) -> AsyncIterator[bytes]:
    for part in parts:
        yield part


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_no_path(bench: Bench, name: str) -> None:
    before = kept(bench)
    with bench.client() as client:
        answer = client.post("/api/files", params={"name": name}, content=b"time [s]\n0\n")
        made = answer.json()
        assert answer.status_code == 201, made
        fetched = client.get(f"/api/files/{made['key']}")
    new = {Path(path) for path in kept(bench) - before}
    assert {path.name for path in new} == {made["key"], made["name"]}
    assert all(path.is_relative_to(bench.folder) for path in new)
    assert fetched.content == b"time [s]\n0\n"
    assert fetched.headers["content-disposition"].startswith("attachment")
    assert fetched.headers["content-type"] == "application/octet-stream"


@given(st.text(max_size=300))
def test_a_safe_name_is_safe(name: str) -> None:
    safe = clean_name(name)
    assert safe
    assert len(safe.encode()) <= 255
    assert not set(safe) & set('/\\\0:*?"<>|\n\r\t')
    assert safe not in (".", "..")
    assert not safe.startswith((".", " "))
    assert safe == safe.rstrip(" .")
    assert clean_name(safe) == safe


@pytest.mark.parametrize("key", ["..", "0" * 15, "0" * 17, "0" * 16, "0" * 15 + "\n", "A" * 16])
def test_a_key_that_is_none(bench: Bench, key: str) -> None:
    with bench.client() as client:
        answer = client.get(f"/api/files/{key.replace(chr(10), '%0a')}")
    assert answer.status_code in (400, 404)
    assert "error" in answer.json()
    with pytest.raises(DataError, match="no such file"):
        UploadFolder(bench.folder).path(key)


@pytest.mark.parametrize("told", [True, False])
def test_200_megabytes_are_refused_with_memory_flat(bench: Bench, told: bool) -> None:
    before, held = kept(bench), resident(bench.pid)
    headers = {"Content-Length": str(200 * 2**20)} if told else {}
    with bench.client() as client:
        answer = client.post("/api/files", params={"name": "big.csv"}, content=chunks(200), headers=headers)
        assert client.get("/api/status").status_code == 200
    assert answer.status_code == 413
    assert "64 MiB" in answer.json()["error"]
    assert kept(bench) == before
    assert resident(bench.pid) < held + 30.0


@pytest.mark.parametrize("told", [True, False])
def test_a_message_that_is_too_long_is_refused(bench: Bench, told: bool) -> None:
    headers = {"Content-Length": str(20 * 2**20)} if told else {}
    with bench.client() as client:
        answer = client.post("/api/call/run", content=chunks(20), headers=headers)
    assert answer.status_code == 413
    assert "8,388,608 bytes" in answer.json()["error"]


def test_an_upload_that_breaks_off_leaves_nothing(bench: Bench) -> None:
    before = kept(bench)
    head = (
        f"POST /api/files?name=half.csv HTTP/1.1\r\nHost: 127.0.0.1:{bench.port}\r\n"
        f"Authorization: Bearer {bench.token}\r\nX-Tab: tab-of-tests\r\n"
        "Content-Length: 1000000\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", bench.port)) as wire:
        wire.sendall(head.encode() + b"x" * 1000)
        wait_until(lambda: kept(bench) != before)
    wait_until(lambda: kept(bench) == before)


def wait_until(true: Callable[[], bool], seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_an_upload_needs_a_name(bench: Bench) -> None:
    with bench.client() as client:
        answer = client.post("/api/files", content=b"x")
    assert answer.status_code == 400
    assert "?name=" in answer.json()["error"]


def test_an_empty_file_is_kept(bench: Bench) -> None:
    with bench.client() as client:
        made = client.post("/api/files", params={"name": "empty.csv"}, content=b"").json()
    assert made["bytes"] == 0


def test_a_full_disk_is_a_sentence(tmp_path: Path) -> None:
    async def filling() -> AsyncIterator[bytes]:
        yield b"x" * 1000
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(Refusal, match=r"could not be kept: No space left") as caught:
        asyncio.run(UploadFolder(tmp_path).take("a.csv", filling()))
    assert caught.value.status == 507
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("")
    with pytest.raises(DataError, match="folder of the bench cannot be used"):
        asyncio.run(UploadFolder(occupied).take("a.csv", streamed([b"x"])))


def test_a_file_of_the_greatest_size_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uploads, "MOST_BYTES", 100)
    key, path = asyncio.run(UploadFolder(tmp_path).take("a.csv", streamed([b"x" * 60, b"x" * 40])))
    assert path.stat().st_size == 100
    assert UploadFolder(tmp_path).path(key) == path
    with pytest.raises(Refusal):
        asyncio.run(UploadFolder(tmp_path).take("a.csv", streamed([b"x" * 60, b"x" * 41])))
    assert [found.name for found in tmp_path.iterdir()] == [key]


def test_all_files_together_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uploads, "MOST_IN_ALL", 100)
    drawer = UploadFolder(tmp_path)
    asyncio.run(drawer.take("a.csv", streamed([b"x" * 60])))
    with pytest.raises(Refusal, match="All files uploaded since the bench began") as caught:
        asyncio.run(drawer.take("b.csv", streamed([b"x" * 30, b"x" * 30])))
    assert caught.value.status == 413
    assert len(list(tmp_path.iterdir())) == 1
    asyncio.run(drawer.take("c.csv", streamed([b"x" * 40])))  # what was refused does not count
    assert drawer.uploaded_bytes == 100


def test_files_under_way_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two halves of the limit and a byte, side by side: one of them is refused."""
    monkeypatch.setattr(uploads, "MOST_IN_ALL", 100)
    drawer = UploadFolder(tmp_path)

    async def slowly() -> AsyncIterator[bytes]:
        for _ in range(3):
            yield b"x" * 17
            await asyncio.sleep(0.0)

    async def both() -> list[object]:
        takes = drawer.take("a.csv", slowly()), drawer.take("b.csv", slowly())
        return list(await asyncio.gather(*takes, return_exceptions=True))

    found = asyncio.run(both())
    assert sum(isinstance(one, Refusal) for one in found) == 1
    assert drawer.uploaded_bytes == 51
