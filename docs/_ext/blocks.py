"""Markdown about the blocks of dynamic models, from their declarations."""

from __future__ import annotations

from typing import Any

import parts

from martensite.base.errors import InputError
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, AbstractStatic
from martensite.identify.chains.chain_text import parse_block
from martensite.scenario import catalogue

MANY = 12
"""Free numbers beyond which not all names are listed."""


def all_blocks() -> str:
    """A table of all blocks, then a section for each."""
    found = [BLOCKS[name] for name in BLOCKS.names()]
    rows = [
        (
            f"[{cls.registered_name}](#block-{cls.registered_name})",
            parts.code(_written(cls)),
            _kind(cls),
            catalogue.summarise_class(cls),
        )
        for cls in found
    ]
    overview = parts.table(("block", "written, for example", "kind", "what it is"), rows)
    return overview + "\n" + "\n".join(section(cls) for cls in found)


def section(cls: type[AbstractBlock]) -> str:
    """Description, text, parameters and free numbers of a block."""
    example, found = cls(), catalogue.describe_class("block", cls)
    sources = ", ".join(parts.cited(key) for key in cls.cites)
    count = example.states()
    states = f"{count} state{'s' * (count > 1)}" if count else "no memory"
    return "\n".join(
        [
            f"(block-{found['name']})=",
            f"## `{found['name']}`\n",
            f"{found['summary']}\n",
            f"{found['description']}\n",
            parts.parameters_of(cls),
            f"*Text.* {_text(cls)}\n",
            f"*Set from the record.* {_fixed(cls)}.\n",
            f"*As it stands by default:* {example.inputs} in, {example.outputs} out, {states}; "
            f"free numbers: {_numbers(example)}.\n",
            f"Sources: {sources}.\n" if sources else "",
        ]
    )


def _written(cls: type[AbstractBlock]) -> str:
    """Its text with the values that stand by default."""
    return cls().text()


def _kind(cls: type[AbstractBlock]) -> str:
    if cls.linear:
        return "linear"
    return "static" if not cls().states() else "with memory"


def _text(cls: type[AbstractBlock]) -> str:
    if not cls.short:
        return f"As {parts.code(_written(cls))}."
    inner = f"({','.join(cls.shape)})" if cls.shape else ""
    short = f"; one number may follow the name: `{cls.short}5`" if _counted(cls) else ""
    return f"`{cls.short}{inner}`{short}."


def _counted(cls: type[AbstractBlock]) -> bool:
    """Whether a number behind the name is read."""
    try:
        parse_block(f"{cls.short}5")
    except InputError:
        return False
    return True


def _fixed(cls: type[AbstractBlock]) -> str:
    names: Any = cls.fixed
    if not isinstance(names, tuple):
        return "The fixed numbers of its blocks"
    if issubclass(cls, AbstractStatic):
        return "`low` and `high`, the range of its input"
    return ", ".join(parts.code(str(name)) for name in names) or "Nothing"


def _numbers(block: AbstractBlock) -> str:
    names = [parts.code(name) for name in block.numbers()]
    if not names:
        return "none"
    more = f", … ({len(names)} in all)" if len(names) > MANY else ""
    return ", ".join(names[:MANY]) + more
