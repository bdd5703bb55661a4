"""Write `docs/reference/machines.md`, a section of the page on runtimes, from its numbers alone."""

from __future__ import annotations

from typing import Any

from benchmarks.process import ROOT

PAGE = ROOT / "docs/reference/machines.md"
NUMBERS = ROOT / "docs/reference/benchmarks/machines.json"
ABSENT, REFERENCE = "not run here", "Python floats"

HEAD = """## Agreement of all targets

All targets run the same random programs. Plain Python floats are the reference. `python -m benchmarks conformance`
writes this table from [the numbers](benchmarks/machines.json) of one run.

| target | kernels | whole steps | size [kB] | step [µs] | relative to C |
|---|---|---|---|---|---|
"""

FOOT = """
- **kernels**: number of kernels that ran on 256 random inputs, including the ends of their ranges. Each law, element,
  mechanism, heat loss and resistance counts with its first variant. The second value is the largest difference to
  Python floats, divided by the largest value of the output; its kernel is in brackets. C is compiled with `-O1` here.
  The contract tests run all variants.
- **whole steps**: number of systems, and the smallest and the largest difference of all outputs in {steps} steps
  under random signals. 0 means equal in every bit. Some targets omit systems that compile for minutes. The {count}
  systems are: {names}.
- **size**: compressed size for the wire of README.md. The compressed files are
{handed}
- **step**: CPU time of one step of that wire, best of several rounds. *C lanes* runs 256 batch elements at once; the
  time is per element. Python calls the FMU, sets its inputs and reads its outputs in every step. WebAssembly runs in
  Node.js, by wall clock.

```{{warning}}
Use `float32` only for laws and for wires on a load line. If a step balances several unknowns (joints, fibres, several
elements), use `float64`. The exported core refuses such steps in `float32` and reports it. CUDA continues with reduced
accuracy; the result of `antagonistic_wires` differs by more than its range.
```

The rows *CUDA C, on the processor* compile the CUDA source with the C compiler and run its threads one after another.
They test the program, not the speed of a GPU.

Date: {made}. Processor: {processor}. Python {python}, {compiler}. Targets that were not available have no numbers.
"""


def format_share(share: float) -> str:
    """A difference; 0 is equal to the last bit."""
    return "0" if share == 0.0 else f"{share:.0e}"


def format_row(row: dict[str, Any], base: float) -> str:
    """A line of the table."""
    if "missing" in row:
        return f"| {row['machine']} | {ABSENT}: no {row['missing']} | | | | |"
    kernels = row.get("kernels")
    where = f" ({kernels['where']})" if kernels and kernels["largest"] else ""
    shares = sorted(row["steps"].values())
    span = f"{format_share(shares[0])} to {format_share(shares[-1])}" if shares[-1] else "0"
    refused = f"; step refused: {'; '.join(row['unsolved'])}" if "unsolved" in row else ""
    cells = [
        row["machine"],
        f"{kernels['count']}: {format_share(kernels['largest'])}{where}" if kernels else "",
        "reference" if row["machine"] == REFERENCE else f"{len(shares)}: {span}{refused}",
        f"{row['bytes'] / 1e3:.1f}",
        "" if row["step_us"] is None else f"{row['step_us']:.3g}",
        "" if row["step_us"] is None else f"{row['step_us'] / base:.2g}",
    ]
    return f"| {' | '.join(cells)} |"


def render_page(numbers: dict[str, Any]) -> str:
    """All of it."""
    rows = numbers["machines"]
    base = next(row["step_us"] for row in rows if row["machine"] == "C")
    handed: dict[str, list[str]] = {}
    for row in rows:
        handed.setdefault(row["handed"], []).append(row["machine"])
    words = "\n".join(f"  - {what}: {'; '.join(names)}" for what, names in handed.items())
    foot = FOOT.format(
        **{name: numbers[name] for name in ("steps", "made", "processor", "python", "compiler")},
        count=len(numbers["programs"]),
        names="; ".join(numbers["programs"]),
        handed=words,
    )
    return HEAD + "\n".join(format_row(row, base) for row in rows) + "\n" + foot
