"""Measures in headings of a table of conditions: `peak stroke`, `force rise`, `time to 90 % force`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from martensite.base.errors import InputError
from martensite.logs.heading_guess import part_heading
from martensite.logs.layout import IGNORED, QUANTITIES, find_quantity
from martensite.simulate.measures.base import MEASURES, parse_measure

WAYS = {
    **dict.fromkeys(("peak", "max", "maximum", "largest", "highest"), "max"),
    **dict.fromkeys(("min", "minimum", "least", "smallest", "lowest"), "min"),
    **dict.fromkeys(("steady", "final", "end", "settled", "last"), "final"),
    **dict.fromkeys(("rise", "change", "increase", "gain", "delta", "Δ"), "change"),
    **dict.fromkeys(("mean", "average"), "mean"),
    "rms": "rms",
}
"""Word next to an output -> measure of the output."""
STROKES = {"lift", *QUANTITIES["position"].words}
"""Words for the first coordinate of a mechanism."""
_HEADING = re.compile(r"^\s*(.*?)\s*(?:\[\s*([^\]]*?)\s*\])?\s*$")
_ROUND = re.compile(r"^(.*?)\s*\(([^()]*)\)$")
_TIME_TO = re.compile(r"^time to (peak|max(?:imum)?|([\d.]+) ?%)(?: of)?(?: (.+))?$")


def split_heading(text: str) -> tuple[str, str]:
    """Return the name in lower case, and the unit in brackets."""
    match = _HEADING.match(text)
    name, unit = (match[1], match[2] or "") if match else (text.strip(), "")
    round_brackets = _ROUND.match(name)
    if round_brackets and not unit and round_brackets[1].strip() not in MEASURES.names():
        name, unit = round_brackets[1], round_brackets[2]
    if not unit and "_" in name:
        name, unit = part_heading(name)
    plain = "(" in name or "." in name or name.strip() == IGNORED
    return (name.strip() if plain else re.sub(r"[\s_-]+", " ", name.strip().lower())), unit.strip()


def find_measure_words(name: str, outputs: Iterable[str]) -> str:
    """Return the measure in a heading, as text for `parse_measure`; empty for other headings.

    Args:
        name: heading without its unit, as `split_heading` returns it.
        outputs: names of the outputs of the system.
    """
    output_names, plain = list(outputs), name.replace(" ", "-")
    if "(" in name or plain in MEASURES.names():
        return _keep_measure(name if "(" in name else plain)
    match = _TIME_TO.match(name)
    if match is not None:
        share = f"share={match[2]} %" if match[2] else ""
        return _write_time(_find_output(match[3], output_names), share) if match[3] else _write_first_time(share)
    return _write_way([word for word in name.split(" ") if word != "of"], output_names)


def _keep_measure(text: str) -> str:
    """Return the text of a measure; empty for other texts."""
    try:
        parse_measure(text)
    except InputError:
        return ""
    return text


def _write_first_time(share: str) -> str:
    """Return the time to a fraction, or to the peak, of an output that is chosen later."""
    return f"reach-time(, {share})" if share else "peak-time"


def _write_time(output: str, share: str) -> str:
    """Return the time to a fraction of an output, or to its peak."""
    options = ", ".join(filter(None, (output, share)))
    return f"{'reach' if share else 'peak'}-time({options})" if options else "peak-time"


def _write_way(words: Sequence[str], output_names: Sequence[str]) -> str:
    """Return the measure of words such as `peak` next to an output; empty without a match."""
    ways = [word for word in words if word in WAYS]
    rest = " ".join(word for word in words if word not in WAYS)
    if len(ways) != 1 or not rest:
        return ""
    if rest in STROKES and WAYS[ways[0]] == "max":
        return "stroke"
    output = _find_output(rest, output_names)
    return f"{WAYS[ways[0]]}({output})" if output else WAYS[ways[0]]


def _find_output(words: str, output_names: Sequence[str]) -> str:
    """Return the output for some words; empty for the first coordinate."""
    plain = words.replace(" ", "_")
    if plain in output_names or words in STROKES:
        return "" if words in STROKES else plain
    return find_quantity(plain, lambda name: name in output_names) or plain
