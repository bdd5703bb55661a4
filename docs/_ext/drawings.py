"""Drawings of the site in fewer bytes: what nobody sees of an SVG by matplotlib is left out."""

from __future__ import annotations

import re

DIGITS = 2
"""Of coordinates behind the point; a unit is 1/72 inch."""
_UNSEEN = re.compile(r"<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)
_GEOMETRY = re.compile(r'(?<=\s)(d|x|y|points)="([^"]*)"')
_NUMBER = re.compile(r"-?\d+\.\d+(?:e[+-]?\d+)?")
_SPACE = re.compile(r"\s*([A-Za-z])\s*|\s+")


def shorten_drawing(text: str) -> str:
    """The same drawing: coordinates to two digits, no metadata, no comments, no space between tags."""
    seen = _GEOMETRY.sub(lambda found: f'{found[1]}="{_shorten_numbers(found[2])}"', _UNSEEN.sub("", text))
    return re.sub(r">\s+<", "><", seen)


def _shorten_numbers(text: str) -> str:
    short = _NUMBER.sub(lambda found: f"{float(found[0]):.{DIGITS}f}".rstrip("0").rstrip("."), text)
    return _SPACE.sub(lambda found: found[1] or " ", short).strip()
