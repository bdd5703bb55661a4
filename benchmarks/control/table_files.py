"""The table of the benchmark as a file: CSV or JSON of its rows, netCDF of every wire."""

from __future__ import annotations

import io
import json
from dataclasses import astuple
from typing import Any

import numpy as np

from benchmarks.control.competition import COLUMNS, BenchmarkTable
from benchmarks.control.runs import MEASURES

UNITS = {"settling": "s", "energy": "J", "hottest": "K", "itae": "s^2", "cost": "s"}


def format_table(table: BenchmarkTable, ending: str) -> Any:
    """What a file with an ending `.csv`, `.json` or `.nc` holds."""
    if ending == ".json":
        return _format_json(_round_numbers(table.to_json()))
    return _format_netcdf(table) if ending == ".nc" else format_csv(table)


def _format_json(given: dict[str, Any]) -> str:
    """JSON with a line for every row, so that two tables can be laid beside each other."""
    parts = {key: json.dumps(value) for key, value in given.items() if not isinstance(value, list)}
    lists = {key: value for key, value in given.items() if isinstance(value, list)}
    parts |= {key: "[\n" + ",\n".join(map(json.dumps, rows)) + "\n]" for key, rows in lists.items()}
    return "{\n" + ",\n".join(f"{json.dumps(key)}: {text}" for key, text in parts.items()) + "\n}\n"


def format_csv(table: BenchmarkTable) -> str:
    """All rows in SI, with version and digest in the first line."""
    lines = [f"# martensite {table.version}, benchmark {table.digest}", ",".join(COLUMNS)]
    lines += [",".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in astuple(one)) for one in table.rows]
    return "\n".join([*lines, ""])


def _round_numbers(given: Any) -> Any:
    """Numbers to five digits: what differs beyond comes from the compiler."""
    if isinstance(given, dict):
        return {key: _round_numbers(value) for key, value in given.items()}
    if isinstance(given, list):
        return [_round_numbers(value) for value in given]
    return float(f"{given:.5g}") if isinstance(given, float) else given


def _format_netcdf(table: BenchmarkTable) -> Any:
    import h5netcdf

    axes = [list(dict.fromkeys(key[k] for key in table.measures)) for k in range(3)]
    wires = max(len(one["error"]) for one in table.measures.values())
    whole = io.BytesIO()
    with h5netcdf.File(whole, "w") as file:
        file.attrs.update({"martensite": table.version, "benchmark": table.digest})
        dims = dict(zip(("entry", "task", "fault"), axes, strict=True))
        file.dimensions = {**{name: len(row) for name, row in dims.items()}, "wire": wires}
        for name, row in dims.items():
            text = h5netcdf.core.h5py.string_dtype()
            file.create_variable(name, (name,), data=np.array(row, object), dtype=text)
        for name in MEASURES:
            rows = np.full((*map(len, axes), wires), np.nan)
            for key, one in table.measures.items():
                place = tuple(axis.index(label) for axis, label in zip(axes, key, strict=True))
                rows[place][: len(one[name])] = one[name]
            file.create_variable(name, (*dims, "wire"), data=rows).attrs["units"] = UNITS.get(name, "1")
    return whole.getbuffer()
