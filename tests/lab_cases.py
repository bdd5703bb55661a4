"""Files in the layouts of instruments (`flows/lab_files.toml`), with known numbers, and lines spoilt at random."""

from __future__ import annotations

import random
import re
import tomllib
from pathlib import Path
from typing import Any

FILES: dict[str, Any] = tomllib.loads((Path(__file__).parent / "flows/lab_files.toml").read_text("utf-8"))


def write_clock(seconds: float, digits: int = 3) -> str:
    minutes, rest = divmod(seconds, 60.0)
    return f"{int(minutes // 60) % 24:02d}:{int(minutes % 60):02d}:{rest:0{digits + 3 if digits else 2}.{digits}f}"


def write_row(case: dict[str, Any], k: int) -> str:
    turn = min(k, 39 - k)
    values = {
        **{"k": k, "t": 0.1 * k, "T": 20.0 + 2.0 * k, "e": 4.0 - 0.1 * k, "s": 100.0 + 0.25 * k, "h": 100 * k},
        **{"c": write_clock(86_398.0 + 0.1 * k), "S": write_clock(36_000.0 + k, 0), "m": 100 * (k % 10)},
        **{"q": write_clock(36_000.0 + k // 10, 0), "w": (2**32 - 1000 + 100 * k) % 2**32, "d": 0.1 * (k - (k > 20))},
        **{"v": (65_000 + 100 * k) % 2**16, "x": 20.0 + 5.0 * turn, "y": 0.04 - 0.0018 * turn, "z": 172 + k % 3},
        **{
            "g": 0.001 + 0.002 * turn,
            "p": 1000 + 100 * (k // 20) - 1500 * (k >= 300),
            "i": 20 * (k // 20) + k % 7 * 0.3,
        },
    }
    side = [*case["side"], *[","] * 40][k] + "," if "side" in case else ""
    return side + case["row"].format(**values)


def write_case(folder: Path, name: str) -> Path:
    case = FILES[name]
    text = "\n".join(write_row(case, k) for k in range(case.get("rows", 40)))
    text = (text.replace(".", ",") if case.get("comma") else text).replace(*case.get("replace", ("\r", "")))
    head, end = (f"{case['head']}\n" if "head" in case else ""), case.get("end", "")
    path = folder / name
    path.write_bytes(f"{head}{text}\n{end}\n".encode(case.get("encoding", "utf-8")))
    return path


def spoil_lines(raw: bytes, rng: random.Random) -> bytes:
    """Lines cut, emptied, changed for hostile ones, or put elsewhere."""
    lines = raw.split(b"\n")
    hostile = (b"", b",,,,", b"nan,nan", b"1e999,2", b"12:61:99,3", b"99/99/9999,1", b'"')
    for _ in range(rng.randrange(1, 6)):
        at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
        lines[at] = rng.choice((*hostile, lines[at][: rng.randrange(1 + len(lines[at]))], lines[other]))
    return b"\n".join(lines)


UNITS = ("s", "ms", "min", "°C", "°F", "K", "N", "kN", "mN", "MPa", "psi", "%", "mm", "um", "in", "m", "V", "mV", "mA")


def spoil_heads(raw: bytes, rng: random.Random) -> bytes:
    """Heading lines dropped or doubled, and their words changed: another unit, another case, no unit."""
    coding = "utf-16" if raw[:2] == b"\xff\xfe" else "utf-16-le" if 3 * raw.count(0) > len(raw) else "latin-1"
    lines = raw.decode(coding).split("\n")
    heads = [k for k, line in enumerate(lines) if sum(c.isalpha() for c in line) > 1][:25]
    for _ in range(rng.randrange(1, 4)):
        at = rng.choice(heads or [0])
        parts = re.split(r"([A-Za-z°%]+)", lines[at])
        words = range(1, len(parts), 2)
        pick = rng.choice(("unit", "unit", "unit", "case", "none", "drop", "twice", "swap"))
        if pick in ("drop", "twice"):
            lines[at] = "" if pick == "drop" else f"{lines[at]}\n{lines[at]}"
        elif words:
            one, other = rng.choice(words), rng.choice(words)
            own = {"unit": rng.choice(UNITS), "case": parts[one].swapcase(), "none": "", "swap": parts[other]}[pick]
            parts[one] = own if coding != "latin-1" else own.encode().decode("latin-1")
            lines[at] = "".join(parts)
    return "\n".join(lines).encode(coding)
