"""Chains as text: `poly2 | oe(3,3,1) | pwl10`.

    chain = stage { "|" stage }
    stage = block  or  "[" chain { "&" chain } "]"  or  "[" chain { "+" chain } "]"  or  "[" chain "<" chain "]"
    block = name [ number ]  or  name "(" word { "," word } ")"

A block is its short name with its structure: numbers, then choices such as `pwl(10,fixed)`, in brackets, or a single
number after the name. In square brackets, blocks between `&` are in parallel on separate signals, blocks between `+`
are summed, and the chain after `<` is the feedback of the chain before it. Each may be a chain, or in brackets. Case
and spaces are ignored.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from martensite.base.errors import InputError, MartensiteError, suggest_name
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, AbstractStatic
from martensite.identify.blocks.block_joins import FeedbackLoop, Series, SummedBlocks
from martensite.identify.blocks.saturation import AbstractInterval
from martensite.identify.blocks.side_by_side import AbstractComposite, SideBySide

_BLOCK = re.compile(r"([a-z][a-z_-]*)\s*(?:\(([^()]*)\)|(\d+))?")
JOINED: dict[str, type[AbstractComposite]] = {one.sign: one for one in (SideBySide, SummedBlocks, FeedbackLoop)}


def short_names() -> dict[str, type[AbstractBlock]]:
    """Return the blocks by their names in texts."""
    blocks = (BLOCKS[name] for name in BLOCKS.names())
    return {block.short: block for block in blocks if block.short}


def parse_block(text: str) -> AbstractBlock:
    """Return one block, or a composite block, from its text.

    Raises:
        InputError: the text is no block, or the name is unknown.
    """
    text = text.strip()
    if text.startswith("["):
        return _parse_joined(text)
    match = _BLOCK.fullmatch(text.lower())
    if match is None:
        raise InputError(
            f"`{text}` is no block; write a name and its orders, such as `poly2`, `pwl(10)` or `oe(3,3,1)`."
        )
    name, inner, digits = match.groups()
    blocks = short_names()
    if name not in blocks:
        raise InputError(f"There is no block `{name}`. {suggest_name(name, blocks)}")
    words = [w.strip() for w in (inner or digits or "").split(",") if w.strip()]
    return _build_block(blocks[name], text, words)


def _split_outside(text: str, sign: str) -> list[str]:
    """Return the parts of a text between signs outside all brackets."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([") - (character in ")]")
        if character == sign and not depth:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def _parse_joined(text: str) -> AbstractBlock:
    """Return the composite block of a text in square brackets."""
    signs = [sign for sign in JOINED if len(_split_outside(text[1:-1], sign)) > 1]
    parts = _split_outside(text[1:-1], signs[0]) if signs else [text[1:-1]]
    words = [_split_outside(part, "|") for part in parts]
    if len(signs) > 1 or not text.endswith("]") or any(not word.strip() for part in words for word in part):
        raise InputError(
            f"`{text}` is not well written; between square brackets stand blocks or chains with one kind of sign "
            "between them: `[poly2 & unit]` side by side, `[poly2 + pi8]` summed, `[oe(2,2,1) < boucwen]` the second "
            "in the feedback of the first."
        )
    blocks = [_join_series([parse_block(word) for word in part]) for part in words]
    if not signs:
        return blocks[0]
    try:
        return JOINED[signs[0]](blocks=tuple(blocks))
    except MartensiteError as error:
        raise InputError(f"Block `{text}`: {error}") from None


def _join_series(blocks: list[AbstractBlock]) -> AbstractBlock:
    return blocks[0] if len(blocks) == 1 else Series(blocks=tuple(blocks))


def _build_block(block: type[AbstractBlock], text: str, words: list[str]) -> AbstractBlock:
    if len(words) > len(block.shape):
        allowed = f"at most {len(block.shape)}: {', '.join(block.shape)}" if block.shape else "none"
        raise InputError(f"Block `{text}` is given {len(words)}, but `{block.short}` takes {allowed}.")
    try:
        pairs = zip(block.shape, words, strict=False)
        result = block(**{name: _parse_value(block, name, word) for name, word in pairs})
    except ValueError:
        raise InputError(f"The numbers of block `{text}` must be plain numbers.") from None
    except MartensiteError as error:
        raise InputError(f"Block `{text}`: {error}") from None
    return result


def _parse_value(block: type[AbstractBlock], name: str, word: str) -> float | str:
    return word if block.declarations[name].kind == "option" else float(word)


def parse_chain(text: str) -> tuple[AbstractBlock, ...]:
    """Return the blocks of a text; only the last static block has an offset.

    Raises:
        InputError: a block is unknown, or the text is invalid.
    """
    _check_brackets(text)
    words = _split_outside(text, "|")
    if not text.strip() or any(not word.strip() for word in words):
        raise InputError(f"`{text}` is no chain; write blocks between bars, such as `poly2 | oe(3,3,1) | pwl10`.")
    return fix_gauge([parse_block(word) for word in words])


def _check_brackets(text: str) -> None:
    opened: list[str] = []
    for character in text:
        if character in "([":
            opened.append(character)
        elif character in ")]" and (not opened or opened.pop() + character not in ("()", "[]")):
            raise InputError(f"In `{text}` nothing opens the bracket `{character}`.")
    if opened:
        raise InputError(f"In `{text}` nothing closes the bracket `{opened[-1]}`.")


def fix_gauge(blocks: list[AbstractBlock]) -> tuple[AbstractBlock, ...]:
    """Return the blocks with an offset only in the last static block of each signal path.

    Two offsets cannot be identified. Saturations and dead zones before it have the gain 1 for the same reason.
    """
    return _fix_series(blocks, [False] * (blocks[-1].outputs if blocks else 0))[0]


def _fix_series(blocks: Sequence[AbstractBlock], after: list[bool]) -> tuple[tuple[AbstractBlock, ...], list[bool]]:
    """Return blocks in series without redundant offsets, and whether an offset follows each input."""
    fixed: list[AbstractBlock] = []
    for block in reversed(blocks):
        changed, after = _drop_offset(block, after)
        fixed.append(changed)
    return tuple(reversed(fixed)), after


def _drop_offset(block: AbstractBlock, after: list[bool]) -> tuple[AbstractBlock, list[bool]]:
    """Return a block without an offset if one follows, and whether one follows each input."""
    if isinstance(block, SideBySide):
        shares = block.split(after, lambda child: child.outputs)
        fixed = [_drop_offset(child, flags_after) for child, flags_after in shares]
        children = tuple(child for child, _ in fixed)
        return block.with_parts(blocks=children), [flag for _, flags in fixed for flag in flags]
    if isinstance(block, AbstractComposite):
        return _fix_joined(block, after)
    follows = any(after)
    if isinstance(block, AbstractStatic):
        gain = {"gain": "one"} if isinstance(block, AbstractInterval) else {}
        return (block.with_parts(offset="no", **gain) if follows else block), [True]
    return block, [follows] * block.inputs


def _fix_joined(block: AbstractComposite, after: list[bool]) -> tuple[AbstractBlock, list[bool]]:
    """Return a series, sum or feedback with fixed gains and offsets."""
    if isinstance(block, Series):
        children, flags = _fix_series(block.blocks, after)
        return block.with_parts(blocks=children), flags
    fixed: list[AbstractBlock] = []
    for child in block.blocks:  # the first block of a sum that can have an offset has it
        changed, flags = _drop_offset(child, after)
        fixed.append(changed)
        after = [True] if isinstance(block, FeedbackLoop) else [any((*after, *flags))]
    return block.with_parts(blocks=tuple(fixed)), after * block.inputs
