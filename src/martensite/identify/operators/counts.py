"""Numbers of units, knots, powers: whole."""

from __future__ import annotations

from martensite.base.errors import ParameterError
from martensite.identify.blocks.base import AbstractBlock


def check_whole(block: AbstractBlock) -> None:
    """Raise `ParameterError` unless the numbers in the text of a block are whole."""
    for name in block.shape:
        value = getattr(block, name)
        if isinstance(value, float) and value != int(value):
            raise ParameterError(
                f"Parameter `{name}` of `{block.registered_name}` must be a whole number, but is {value:g}."
            )
