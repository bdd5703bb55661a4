"""Texts around a WebAssembly module: the script, its types, and a guide."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template
from typing import Any

from martensite.export.c_core import CCore
from martensite.export.c_names import CoreVariable
from martensite.export.c_text import count_elements

STEP = 0.01
"""Step [s] in the guide for a model with steps of any length."""


def read_text(name: str) -> str:
    """Return a text of this folder."""
    return (Path(__file__).parent / name).read_text(encoding="utf-8")


def script_text(core: CCore, first: Sequence[float]) -> str:
    """Return NAME.js."""
    sizes = {
        "INPUTS": len(core.inputs),
        "OUTPUTS": len(core.outputs),
        "SIZE": sum(map(count_elements, (len(core.parameters), core.constants, core.states))) + 2,
        "TAG": zlib.crc32(core.source.encode()),
    }
    tables = {
        "parameters": {one.name: _describe_parameter(one) for one in core.parameters},
        "signals": {one.name: _describe(one) | {"first": first[one.index]} for one in core.inputs},
        "outputs": {one.name: _describe(one) for one in core.outputs},
    }
    begin = f"// {_flatten(core.description)}, as WebAssembly. Written by martensite (`martensite export wasm`).\n\n"
    begin += "".join(f"const {name} = {value};\n" for name, value in sizes.items())
    begin += "".join(f"export const {name} = {_print_table(rows)};\n" for name, rows in tables.items())
    begin += f"export const sampleTime = {core.sample_time!r};\n\n"
    return begin + read_text("wrapper.js").replace("$NAME", core.name)


def types_text(core: CCore) -> str:
    """Return NAME.d.ts."""
    return Template(read_text("wrapper.d.ts")).substitute(
        NAME=core.name,
        TITLE=_flatten(core.description).replace("*/", "* /"),
        PARAMETERS=_join_names(core.parameters),
        SIGNALS=_join_names(core.inputs),
        OUTPUTS=_join_names(core.outputs),
    )


def guide_text(core: CCore, title: str, first: Sequence[float], raw: int, packed: int) -> str:
    """Return README.md, with the sizes of the module [bytes]."""
    given = ", ".join(f"{json.dumps(one.name)}: {first[one.index]!r}" for one in core.inputs[:1])
    driven = {one.name for one in core.inputs}
    parameter = next((one for one in core.parameters if one.has_effect), core.parameters[0])
    return Template(read_text("guide.md")).substitute(
        NAME=core.name,
        TITLE=_flatten(title),
        DESCRIPTION=_flatten(core.description),
        RAW=f"{raw:,}",
        PACKED=f"{packed:,}",
        PARAMETER=parameter.name,
        VALUE=f"{parameter.default!r}",
        STEP=core.sample_time or STEP,
        GIVEN=f"{{ {given} }}",
        OUTPUT=next((one.name for one in core.outputs if one.name not in driven), core.outputs[0].name),
        SIGNALS=_print_rows(core.inputs),
        OUTPUTS=_print_rows(core.outputs),
        PARAMETERS=_print_rows(core.parameters),
    )


def _flatten(text: str) -> str:
    """Return a text on one line."""
    return " ".join(text.split())


def _describe(one: CoreVariable) -> dict[str, Any]:
    return {"index": one.index, "unit": one.unit, "words": one.words}


def _describe_parameter(one: CoreVariable) -> dict[str, Any]:
    return _describe(one) | {"value": one.default, "low": one.low, "high": one.high, "used": one.has_effect}


def _print_table(rows: Mapping[str, Any]) -> str:
    """Return a JavaScript object, which knows `Infinity`, unlike JSON."""
    lines = "".join(f"  {json.dumps(name)}: {json.dumps(row)},\n" for name, row in rows.items())
    return f"{{\n{lines}}}"


def _join_names(variables: Sequence[CoreVariable]) -> str:
    return "".join(f"\n  | {json.dumps(one.name)}" for one in variables) or "never"


def _print_rows(variables: Sequence[CoreVariable]) -> str:
    cells = [(f"`{one.name}`", one.unit, _flatten(one.words).replace("|", "\\|")) for one in variables]
    return "\n".join(f"| {' | '.join(row)} |" for row in [("name", "unit", ""), ("---", "---", "---"), *cells])
