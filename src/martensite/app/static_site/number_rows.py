"""Rows of numbers in one entry of the document, such as the values of a table, as separate controls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

from martensite.app.forms.controls import SIZES, describe_display
from martensite.app.forms.form_types import NumberNode, RowNode, ScenarioForm
from martensite.app.messages import JsonTable
from martensite.base import units

REACH = 10.0
"""Largest value of a slider, relative to the largest of its row."""
LONGEST = 50
"""Largest number of values of a row."""


@dataclass(frozen=True)
class NumberRow:
    """A row with a control for each value; its path is that of the row and an index."""

    path: str
    entries: tuple[str | float, ...]
    """Entries as in the document."""
    items: list[NumberNode]

    def describe(self) -> JsonTable:
        """Return the display of the values."""
        first = self.items[0]
        return {"count": len(self.items), **{name: first[name] for name in ("unit", "factor", "offset", "label")}}


def list_rows(form: ScenarioForm) -> Iterator[RowNode]:
    """Yield the rows with a known unit: values of tables, of a drive or of a reference."""
    waiting = list[object](form["sections"])
    while waiting:
        one = cast("JsonTable", waiting.pop(0))
        if one["sort"] == "row" and one["several"] and one["unit"]:
            yield cast("RowNode", one)
        waiting[:0] = one.get("items", [])


def read_row(node: RowNode) -> NumberRow:
    """Return the values of a row."""
    unit, texts = node["unit"] or "1", tuple(part.strip() for part in node["value"].split(","))
    if len(texts) > LONGEST:
        raise ValueError(f"it has more than {LONGEST} numbers")
    values = [units.parse_quantity(text, unit) for text in texts]
    largest = max(map(abs, values)) or SIZES.get(unit, 1.0)
    end, how = REACH * largest, describe_display(unit, largest)
    items = [
        cast(
            "NumberNode",
            {
                **node,
                **how,
                "sort": "number",
                "path": f"{node['path']}.{k}",
                "value": value,
                "slider": {"low": -end, "high": end, "log": False, "whole": False},
            },
        )
        for k, value in enumerate(values)
    ]
    return NumberRow(node["path"], texts if node["quantities"] else tuple(values), items)
