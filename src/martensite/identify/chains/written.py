"""Chains as text: `poly2 | oe(3,3,1) | pwl10`.

A block is its short name with its structure as numbers, in brackets or, if it is one, behind the
name. Blocks between `&` in square brackets run side by side, each on signals of its own:
`[poly2 & unit]`.
"""

from __future__ import annotations

import re

from martensite.errors import InputError, MartensiteError, suggestion
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, AbstractStatic

_BLOCK = re.compile(r"([a-z][a-z_-]*)\s*(?:\(([^()]*)\)|(\d+))?")


def short_names() -> dict[str, type[AbstractBlock]]:
    """Blocks by the name that they have in texts."""
    blocks = (BLOCKS[name] for name in BLOCKS.names())
    return {block.short: block for block in blocks if block.short}


def parse_block(text: str) -> AbstractBlock:
    """One block from its text.

    Raises:
        InputError: it is not written like a block, or there is none of that name.
    """
    found = _BLOCK.fullmatch(text.strip().lower())
    if found is None:
        raise InputError(
            f"`{text.strip()}` is no block; write a name and its orders, such as `poly2`, "
            f"`pwl(10)` or `oe(3,3,1)`."
        )
    name, inner, digits = found.groups()
    known = short_names()
    if name not in known:
        raise InputError(f"There is no block `{name}`. {suggestion(name, known)}")
    words = [w.strip() for w in (inner or digits or "").split(",") if w.strip()]
    return _built(known[name], text.strip(), words)


def _built(block: type[AbstractBlock], text: str, words: list[str]) -> AbstractBlock:
    if len(words) > len(block.shape):
        raise InputError(
            f"Block `{text}` has {len(words)} numbers, but `{block.short}` takes at most "
            f"{len(block.shape)}{': ' if block.shape else ''}{', '.join(block.shape)}."
        )
    try:
        values = {name: float(word) for name, word in zip(block.shape, words, strict=False)}
        return block(**values)
    except ValueError:
        raise InputError(f"The numbers of block `{text}` must be plain numbers.") from None
    except MartensiteError as error:
        raise InputError(f"Block `{text}`: {error}") from None


def parse_chain(text: str) -> tuple[AbstractBlock, ...]:
    """The blocks of a text, their gauge set: only the last static block has an offset.

    Raises:
        InputError: a block is unknown or not well written.
    """
    words = text.split("|")
    if not text.strip() or any(not word.strip() for word in words):
        raise InputError(
            f"`{text}` is no chain; write blocks between bars, such as `poly2 | oe(3,3,1) | pwl10`."
        )
    return gauged([parse_block(word) for word in words])


def gauged(blocks: list[AbstractBlock]) -> tuple[AbstractBlock, ...]:
    """Blocks of which only the last static one has an offset: two could not be told apart."""
    static = [i for i, block in enumerate(blocks) if isinstance(block, AbstractStatic)]
    for i in static[:-1]:
        blocks[i] = blocks[i].with_parts(offset="no")
    return tuple(blocks)
