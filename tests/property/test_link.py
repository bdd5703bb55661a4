"""The link between host and board: both ends take the same frames, and nothing that is garbled.

Source of truth: the C of the firmware for the Python of the host and the other way round, `zlib.crc32`, and what was
done to the line on purpose.
"""

from __future__ import annotations

import ctypes
import random
import subprocess
import zlib
from importlib.resources import files
from typing import Any

import pytest

from martensite.boards.link.frames import BoardClock, FrameReader, encode_frame
from martensite.boards.link.messages import KINDS, MOST, pack_message, print_header
from martensite.kernels.compiler import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
COUNTS = ("good", "garbled", "lost", "doubled", "reordered")


class Receiver(ctypes.Structure):
    """`link_receiver`."""

    _fields_ = (
        ("bytes", ctypes.c_uint8 * (MOST + 9)),
        ("filled", ctypes.c_uint8),
        ("spilt", ctypes.c_uint8),
        ("begun", ctypes.c_uint8),
        ("newest", ctypes.c_uint16),
        ("window", ctypes.c_uint32),
        *((name, ctypes.c_uint32) for name in COUNTS),
    )


class Taken(ctypes.Structure):
    """`link_message`."""

    _fields_ = (
        ("type", ctypes.c_uint8),
        ("size", ctypes.c_uint8),
        ("number", ctypes.c_uint16),
        ("payload", ctypes.POINTER(ctypes.c_uint8)),
    )


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder, home = tmp_path_factory.mktemp("link"), files("martensite.boards") / "c"
    for name in ("link.c", "link.h"):
        (folder / name).write_text((home / name).read_text("utf-8"), "utf-8")
    (folder / "messages.h").write_text(print_header(), "utf-8")
    command = ["cc", "-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-shared", "-fPIC"]
    subprocess.run([*command, "link.c", "-include", "messages.h", "-o", "link.so"], cwd=folder, check=True)
    found = ctypes.CDLL(str(folder / "link.so"))
    found.link_check.restype = ctypes.c_uint32
    found.link_unwrap.restype = ctypes.c_uint64
    return found


def receive_in_c(library: Any, data: bytes) -> tuple[list[tuple[int, int, bytes]], dict[str, int]]:
    receiver, taken, found = Receiver(), Taken(), []
    library.link_begin(ctypes.byref(receiver))
    for byte in data:
        if library.link_receive(ctypes.byref(receiver), byte, ctypes.byref(taken)):
            found.append((taken.type, taken.number, bytes(taken.payload[: taken.size])))
    return found, {name: getattr(receiver, name) for name in COUNTS}


def draw_frames(rng: random.Random, count: int) -> list[bytes]:
    """Frames of all messages, with numbers that wrap."""
    found, first = [], 65536 - count // 2
    for k in range(count):
        kind = rng.choice(list(KINDS.values()))
        payload = rng.randbytes(kind.layout.size + (4 * rng.randrange(20) if kind.repeated else 0))
        found.append(encode_frame(kind.code, first + k, payload))
    return found


def test_both_ends_write_the_same_frame(library: Any) -> None:
    rng, out = random.Random(1), (ctypes.c_uint8 * (MOST + 9))()
    for size in (0, 1, 5, MOST):
        for fill in (rng.randbytes(size), bytes(size)):
            length = library.link_encode(out, 0x83, 40_000, fill, size)
            assert bytes(out[:length]) == encode_frame(0x83, 40_000, fill)
            assert library.link_check(fill, size) == zlib.crc32(fill)
    assert library.link_encode(out, 1, 0, bytes(MOST + 1), MOST + 1) == 0


def test_what_happens_on_a_line_is_counted_alike(library: Any) -> None:
    rng, line = random.Random(2), list[bytes]()
    frames, lost, doubled, reordered, garbled = draw_frames(rng, 4000), 0, 0, 0, 0
    k = 0
    while k < len(frames):
        event = (
            rng.choice(("plain",) * 8 + ("lose", "double", "swap", "garble")) if 0 < k < len(frames) - 2 else "plain"
        )
        if event == "lose":
            lost += 1
        elif event == "double":
            line += [frames[k], frames[k]]
            doubled += 1
        elif event == "swap":
            line += [frames[k + 1], frames[k]]
            reordered += 1
            k += 1
        elif event == "garble":
            bad = bytearray(frames[k])
            bad[rng.randrange(len(bad) - 1)] ^= rng.choice((0x10, 0x55, 0x80)) or 1
            line.append(bytes(bad).replace(b"\0", b"\x01")[:-1] + b"\0")
            garbled += 1
            lost += 1
        else:
            line.append(frames[k])
        k += 1
    data = b"".join(line)
    in_c, counts = receive_in_c(library, data)
    reader = FrameReader()
    in_python = [
        one.number for piece in (data[i : i + 97] for i in range(0, len(data), 97)) for one in reader.feed(piece)
    ]
    assert counts == {name: getattr(reader.counts, name) for name in COUNTS}
    assert [number for _, number, _ in in_c] == in_python
    assert (counts["lost"], counts["doubled"], counts["reordered"]) == (lost, doubled, reordered)
    assert counts["garbled"] == garbled and counts["good"] == len(in_python) == len(frames) - lost - reordered


@pytest.mark.parametrize("seed", range(2))
def test_nothing_garbled_is_taken(library: Any, seed: int) -> None:
    """Bits flipped, bytes lost, inserted and cut, bursts, and noise without any frame."""
    rng = random.Random(seed)
    frames, line = draw_frames(rng, 500), list[bytes]()
    sent = set(frames)
    for _ in range(5000):
        bad = bytearray(rng.choice(frames)[:-1])
        for _ in range(rng.randint(1, 6)):
            place = rng.randrange(len(bad))
            match rng.randrange(4):
                case 0:
                    bad[place] ^= 1 << rng.randrange(8)
                case 1:
                    bad.insert(place, rng.randrange(256))
                case 2 if len(bad) > 1:
                    del bad[place]
                case _:
                    bad[place:] = rng.randbytes(rng.randrange(1, 200))
        pieces = bytes(bad).split(b"\0")
        line += [piece + b"\0" for piece in pieces if piece + b"\0" not in sent]
    data = b"".join(line)
    in_c, _ = receive_in_c(library, data)
    reader = FrameReader()
    assert list(reader.feed(data)) == [] and in_c == []
    assert reader.counts.garbled == sum(piece != b"\0" for piece in line)


def test_a_check_that_is_not_looked_at_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    code, payload = pack_message("set", place=1, value=2.0)
    monkeypatch.setattr(zlib, "crc32", lambda _: 0x01010101)
    bad = bytearray(encode_frame(code, 1, payload))
    bad[4] ^= 2  # the place of the setting
    reader = FrameReader()
    assert list(reader.feed(bytes(bad))) != []


def test_clocks_do_not_wrap(library: Any) -> None:
    clock, in_c, steps = BoardClock(), (ctypes.c_uint32 * 2)(), 5000
    for k in range(steps):
        time = k * 3_000_000
        assert clock.unwrap(time % (1 << 32)) == time == library.link_unwrap(in_c, ctypes.c_uint32(time % (1 << 32)))
