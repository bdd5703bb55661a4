"""A link over a long time, and under garbled frames, on an emulated Uno: `python -m benchmarks.board_link`.

The board tells a sample a millisecond. Its bytes are read twice: as they are, which says what it sent, and through a
line that loses, flips and doubles some of them, which is what the host counts. Nothing may be lost that the host does
not count. Then garbled frames go to the board, which may take none of them, crash, or stop to answer.

simavr takes about 0.6 s for a second of the board, on a core of its own; `--told` says how far it is.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import tempfile
import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

import martensite as ms
from martensite.boards.board_log import BoardLog
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.toolchains import compile_sketch
from martensite.boards.firmware.project import build_firmware
from martensite.boards.link.frames import FrameReader, LinkCounts, encode_frame
from martensite.boards.link.host import BoardLink
from martensite.boards.link.messages import KINDS, Message

EXAMPLE = Path(__file__).parents[1] / "examples" / "closed_loop.toml"
PERIOD = 1000
"""Of a sample [us]."""


@dataclass
class BadLine:
    """A port to a board whose bytes come damaged, and a reader of what it really sent."""

    board: SimavrBoard
    rate: float
    """Damages per byte."""
    rng: random.Random
    truth: FrameReader = field(default_factory=FrameReader)
    told: deque[Message] = field(default_factory=lambda: deque[Message]())
    """Samples of the board that the host has not yet passed."""
    sent: int = 0
    """Samples that the board told."""
    altered: int = 0
    """Samples that the host took and the board did not tell so."""
    gaps: int = 0
    """Of them, those that came later than a period after the one before, in the clock of the board."""
    latest: int | None = None
    """Time of the newest."""

    def read(self, size: int = 1) -> bytes:
        """What comes of what the board sent."""
        data = self.board.read(size)
        for message in self.truth.feed(data):
            if message.name == "telemetry":
                self.count_sample(message.values["time"])
                self.told.append(message)
        return self.damage(data)

    def count_sample(self, micros: int) -> None:
        """Count a sample that the board told."""
        step = PERIOD if self.latest is None else (micros - self.latest) % (1 << 32)
        self.sent, self.gaps, self.latest = self.sent + 1, self.gaps + (step > 1.5 * PERIOD), micros

    def compare(self, message: Message) -> None:
        """Hold a sample that the host took against what the board told."""
        while self.told and self.told[0].number != message.number:
            self.told.popleft()  # lost on the line
        self.altered += not self.told or self.told.popleft() != message

    def damage(self, data: bytes) -> bytes:
        """Bytes with some lost, flipped or doubled."""
        found = bytearray(data)
        for k in range(len(data) - 1, -1, -1):
            if self.rng.random() < self.rate:
                kind = self.rng.randrange(3)
                found[k : k + 1] = ((), (found[k] ^ 1 << self.rng.randrange(8),), (found[k], found[k]))[kind]
        return bytes(found)

    def write(self, data: bytes) -> int:
        """Bytes to the board, whole."""
        return self.board.write(data)

    def close(self) -> None:
        """Nothing: the board is another's."""


def log_long(
    board: SimavrBoard, firmware: dict, seconds: float, rate: float, told: float = math.inf
) -> tuple[dict[str, float], BoardLog]:
    """What a host and its board say about a log, and the log; every `told` seconds it is said so far."""
    line = BadLine(board, 0.0, random.Random(1))
    link, log = BoardLink(line, now=board.now), BoardLog(firmware)
    link.greet()
    line.rate = rate
    link.command("rate", every=1)
    begin, clock, said = board.now(), time.perf_counter(), board.now()
    while (now := board.now()) < begin + seconds:
        for message in link.receive():
            keep_sample(log, line, message)
        if now > said + told:
            said = now
            print_numbers(count_frames(link, line, log, now - begin, time.perf_counter() - clock))
    spent = time.perf_counter() - clock
    line.rate = 0.0
    for _ in range(3):
        link.command("rate", every=0)  # its answers carry the board's count
    for message in link.receive():
        keep_sample(log, line, message)
    return count_frames(link, line, log, board.now() - begin, spent), log


def keep_sample(log: BoardLog, line: BadLine, message: Message) -> None:
    """Log a message of the host if it is a sample, and compare it with what the board told."""
    if message.name == "telemetry":
        log.take(message)
        line.compare(message)


def count_frames(link: BoardLink, line: BadLine, log: BoardLog, seconds: float, spent: float) -> dict[str, float]:
    """What both ends say; a frame that is still on its way, at most one, is told and not yet lost."""
    counts, sent = link.reader.counts, line.truth.counts
    return {
        "seconds": seconds,
        "frames that the board sent": sent.good,
        "lost by the board": sent.lost + line.gaps,
        "taken by the host": counts.good,
        "counted as lost": counts.lost,
        "garbled": counts.garbled,
        "samples told": line.sent,
        "samples logged": len(log),
        "lost unnoticed": sent.good - counts.good - counts.lost,
        "altered unnoticed": line.altered,
        "wall seconds": spent,
    }


def garble(rng: random.Random) -> bytes:
    """A frame of a command that was damaged on its way."""
    kind = rng.choice([one for one in KINDS.values() if one.code < 0x80])
    whole = encode_frame(kind.code, rng.randrange(65536), rng.randbytes(kind.layout.size))
    bad = bytearray(whole[:-1])
    while whole[:-1] in bytes(bad).split(b"\0"):  # a frame that is whole between two ends is not garbled
        for _ in range(rng.randint(1, 4)):
            place = rng.randrange(len(bad))
            match rng.randrange(4):
                case 0:
                    bad[place] ^= 1 << rng.randrange(8)
                case 1:
                    bad.insert(place, rng.randrange(256))
                case 2 if len(bad) > 1:
                    del bad[place]
                case _:
                    bad[place:] = rng.randbytes(rng.randrange(1, 30))
    return bytes(bad) + b"\0"


def send_garbled(board: SimavrBoard, count: int) -> dict[str, float]:
    """How many of many garbled frames a board took; it raises if its processor crashes."""
    link, rng, taken = BoardLink(board, now=board.now), random.Random(2), 0
    before = link.greet().values
    board.turn = 1e-3
    clock = time.perf_counter()
    for _ in range(count):
        board.write(garble(rng))
        taken += sum(1 for _ in link.receive())
    board.run(0.5)
    after = link.greet().values
    same = after["digest"] == before["digest"] and after["time"] > before["time"]
    return {"garbled": count, "accepted": taken, "alive": same, "wall seconds": time.perf_counter() - clock}


def start_board(folder: Path) -> tuple[SimavrBoard, dict]:
    """An Uno with a loop of 1 kHz."""
    text = EXAMPLE.read_text("utf-8").replace('period = "20 ms"', f'period = "{PERIOD} us"')
    (folder / "fast.toml").write_text(text, "utf-8")
    build_firmware(ms.load(folder / "fast.toml"), "uno", name="uno").write(folder / "uno")
    elf = compile_sketch(folder / "uno", "uno")
    board = SimavrBoard(elf, "uno", 500_000, folder)
    board.run(0.1)
    return board, json.loads((folder / "uno" / "firmware.json").read_text("utf-8"))


def print_numbers(found: dict[str, float]) -> None:
    """A line for each."""
    print("\n".join(f"{key}: {value:,.10g}" for key, value in found.items()), end="\n\n", flush=True)


def main() -> None:
    """Print both."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--minutes", type=float, default=60.0)
    words.add_argument("--garbled", type=int, default=100_000)
    words.add_argument("--damage", type=float, default=2e-5, help="per byte")
    words.add_argument("--out", type=Path, help="file to write the log to")
    words.add_argument("--told", type=float, default=60.0, help="say the counts so far after so many seconds")
    asked = words.parse_args()
    with tempfile.TemporaryDirectory() as name:
        board, firmware = start_board(Path(name))
        try:
            board.turn = 4e-3  # four samples a read: an hour takes 35 minutes of a machine
            found, log = log_long(board, firmware, 60.0 * asked.minutes, asked.damage, asked.told)
            print_numbers(found)
            if asked.out is not None:
                names = {"good": "taken by the host", "lost": "counted as lost", "garbled": "garbled"}
                log.write(asked.out, LinkCounts(**{key: int(found[name]) for key, name in names.items()}))
            print_numbers(send_garbled(board, asked.garbled))
        finally:
            board.close()


if __name__ == "__main__":
    main()
