"""The command line that makes the same sweep."""

from __future__ import annotations

import re
import shlex

from martensite.design.sweep.job import SweepRequest
from martensite.design.sweep.plan import CHUNK

_PLAIN = re.compile(r"^[\w./:=,-]+$")
_QUOTABLE = re.compile(r"^[\w .,:;=+/()%^*·µΩ°±²³-]*$")


def quote_words(words: str) -> str:
    """Words as a shell takes them: in double quotes, which all shells know, where that is safe."""
    if _PLAIN.match(words):
        return words
    return f'"{words}"' if _QUOTABLE.match(words) else shlex.quote(words)


def write_command(name: str, asked: SweepRequest, workers: int = 0, step: str = "") -> str:
    """`martensite sweep …` for a scenario that lies in the folder as `name`.toml."""
    pieces = ["martensite sweep", quote_words(f"{name}.toml")]
    pieces += [f"--over {quote_words(words)}" for words in asked.over]
    if asked.sample != "grid":
        pieces.append(f"--sample {quote_words(asked.sample)}")
    pieces += [f"--output {quote_words(words)}" for words in asked.measures]
    options = {
        "seed": asked.seed or None,
        "step": quote_words(step) if step else None,
        "runtime": asked.runtime,
        "workers": workers or None,
        "chunk-size": asked.chunk if asked.chunk != CHUNK else None,
    }
    pieces += [f"--{option} {value}" for option, value in options.items() if value is not None]
    return " ".join(pieces)
