"""The page of all machines says what its numbers say, and they are what the machines do.

Sources of truth: `docs/reference/benchmarks/machines.json`, written by `python -m benchmarks conformance`; and the wire
of README.md played again on machines that take no time.
"""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from benchmarks.conformance import WIRE, compare_rows, draw_program
from benchmarks.conformance_machines import MACHINES
from benchmarks.conformance_page import ABSENT, NUMBERS, PAGE, render_page
from benchmarks.throughput_runs import readme_scenario

MOST = {"float64": 1e-7, "float32": 2e-2}
"""Differences of whole steps that the page may show; those of kernels in doubles are below 1e-11."""
OTHER_WAYS = {("CUDA C, float32, on the processor", "antagonistic_wires")}
"""Where floats do not do, as the page says."""
QUICK = {"NumPy", "C", "C lanes", "exported C core", "exported C core, float32"}


@pytest.fixture(scope="module")
def numbers() -> Any:
    return json.loads(NUMBERS.read_text(encoding="utf-8"))


def test_the_page_is_written_from_its_numbers(numbers: Any) -> None:
    assert PAGE.read_text(encoding="utf-8") == render_page(numbers)


def test_every_machine_is_there_with_its_numbers_or_its_reason(numbers: Any) -> None:
    rows = numbers["machines"]
    assert [row["machine"] for row in rows] == [one.name for one in MACHINES]
    for row, machine in zip(rows, MACHINES, strict=True):
        if "missing" in row:
            assert row["missing"] and "steps" not in row and f"{machine.name} | {ABSENT}" in PAGE.read_text("utf-8")
            continue
        assert {*row["steps"], *row.get("unsolved", ())} == set(machine.only or numbers["programs"])
        assert "unsolved" not in row or machine.precision == "float32"
        for name, share in row["steps"].items():
            assert 0.0 <= share <= MOST[machine.precision] or (machine.name, name) in OTHER_WAYS, (machine.name, name)
        assert 1_000 < row["bytes"] < 200_000
        assert (row["step_us"] is None) == (machine.step is None)
        assert row["step_us"] is None or (math.isfinite(row["step_us"]) and row["step_us"] > 0.0)
        if "kernels" in row:
            assert row["kernels"]["largest"] <= (1e-11 if machine.precision == "float64" else 1.0)
    exact = [row["machine"] for row in rows if not any(row.get("steps", {"": 1.0}).values())]
    assert exact == ["Python floats", "exported C core", "FMU (FMI 2.0)"]  # equal to the last bit


@pytest.mark.usefixtures("c_compiler")
def test_the_wire_is_as_the_page_says(numbers: Any) -> None:
    program = draw_program(WIRE, readme_scenario())
    meant = MACHINES[0].play(program)
    fractions = meant[:, program.compiled.outputs.index("martensite_fraction")]
    assert fractions.max() - fractions.min() > 0.5
    for row, machine in zip(numbers["machines"], MACHINES, strict=True):
        if machine.name in QUICK:
            share = compare_rows(machine.play(program), meant)
            assert share <= 10.0 * row["steps"][WIRE] + 1e-13, machine.name
            assert (share > 1e-9) == (machine.precision == "float32")
