"""Plain values of options pass without pydantic.

Recent versions of typer convert every value by pydantic, even a text to itself; importing it takes a fifth of the time
of a short command. A missing value, a text, a path, a list of these and a default number need no conversion. Numbers
of the command line and all else are converted as typer does.
"""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Any


def spare_conversion(parameters: list[Any]) -> list[Any]:
    """Let parameters of a command take plain values as they are; without effect on other versions of typer."""
    for one in parameters:
        about = getattr(getattr(one, "type_descriptor", None), "parameter_info", None)
        own = about is None or any(getattr(about, name, None) for name in ("parser", "click_type"))
        if not own and "process_value" not in vars(one):
            one.process_value = partial(_process, one, one.process_value)
    return parameters


def _process(one: Any, convert: Any, ctx: Any, value: Any) -> Any:
    """Return a plain value, or what typer converts any other value to."""
    if not _is_plain(one, value):
        return convert(ctx, value)
    several, kind = one.multiple or one.nargs == -1, one.type_descriptor.annotation
    if value is None:
        plain_value = () if several else None
    elif several:
        plain_value = [Path(each) for each in value] if kind == list[Path] else [*value]
    else:
        plain_value = Path(value) if kind is Path else value
    return plain_value if one.callback is None else one.callback(ctx, one, plain_value)


def _is_plain(one: Any, value: Any) -> bool:
    """Return whether typer converts a value to itself, to a list or to a path, without a check that could fail."""
    kind, about = one.type_descriptor.annotation, one.type_descriptor.parameter_info
    if value is None:
        return not one.required
    if one.multiple or one.nargs == -1:
        listed = bool(value) and isinstance(value, (list, tuple))
        return listed and (kind == list[str] or (kind == list[Path] and all(_is_plain_path(about, x) for x in value)))
    if kind is Path:
        return _is_plain_path(about, value)
    return kind in (str, bool, int, float) and type(value) is kind  # a number that is no text is a default


def _is_plain_path(about: Any, value: Any) -> bool:
    checked = about.exists or about.resolve_path or about.writable or about.path_type
    readable = isinstance(value, str) and bool(value) and (os.access(value, os.R_OK) or not os.path.lexists(value))
    return readable and not checked
