"""The page `docs/reference/machines.md`, from its numbers alone."""

from __future__ import annotations

from typing import Any

from benchmarks.process import ROOT

PAGE = ROOT / "docs/reference/machines.md"
NUMBERS = ROOT / "docs/reference/benchmarks/machines.json"
ABSENT, REFERENCE = "not run here", "Python floats"

HEAD = """# Machines

The physics is written once and printed for many machines ([decision 002](../decisions/002-trace-and-print.md)). Here
all of them play the same random programs, and plain Python floats are what is meant. Written by
`python -m benchmarks conformance` from [the numbers](benchmarks/machines.json) of one run.

| machine | kernels | whole steps | size [kB] | step [µs] | to C |
|---|---|---|---|---|---|
"""

FOOT = """
- **kernels**: how many kernels of the first form of laws, elements, mechanisms, heat losses and resistances were run on
  256 random inputs, ends of their ranges among them, and the largest difference to plain floats, as a share of the
  largest value of that output, with the kernel that has it. C is compiled with `-O1` for this. The contract tests run
  them all, in every form.
- **whole steps**: of how many systems, and the least and largest of their differences, of all outputs in {steps} steps
  under random signals; 0 is equal to the last bit. There are {count}:
  {names}. What compiles for minutes is left to fewer machines.
- **size**: of what the machine is handed for the wire of README.md, compressed: {handed}.
- **step**: CPU time of a step of that wire, best of rounds, and its ratio to C. C lanes take 256 lanes at once; the
  time is per lane. The FMU is called from Python, with inputs set and outputs read in every step; WebAssembly runs in
  Node.js, by the clock.
- **float32** holds for laws, and for wires on a load line. Where a step balances more (joints, fibres, several
  elements) it may not: the exported core refuses such steps and says so; a march of CUDA goes on as well as floats
  allow, and the two wires of `antagonistic_wires` go another way by more than the range. Take doubles for those.
- **CUDA C** is made by the C compiler for the processor, one thread after another: that its program is right is
  checked so, how fast a GPU is says [the benchmark](benchmarks.md). It shows the outputs that are judged.

Made {made}: {processor}; Python {python}, {compiler}. What was not there is said to be so; its numbers are in no row.
"""


def format_share(share: float) -> str:
    """A difference; 0 is equal to the last bit."""
    return "0" if share == 0.0 else f"{share:.0e}"


def format_row(row: dict[str, Any], base: float) -> str:
    """A line of the table."""
    if "missing" in row:
        return f"| {row['machine']} | {ABSENT}: there is no {row['missing']} | | | | |"
    kernels = row.get("kernels")
    where = f" ({kernels['where']})" if kernels and kernels["largest"] else ""
    shares = sorted(row["steps"].values())
    span = f"{format_share(shares[0])} to {format_share(shares[-1])}" if shares[-1] else "0"
    refused = f"; a step refused: {'; '.join(row['unsolved'])}" if "unsolved" in row else ""
    cells = [
        row["machine"],
        f"{kernels['count']}: {format_share(kernels['largest'])}{where}" if kernels else "",
        "meant" if row["machine"] == REFERENCE else f"{len(shares)}: {span}{refused}",
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
    words = "; ".join(f"{what} ({', '.join(names)})" for what, names in handed.items())
    foot = FOOT.format(
        **{name: numbers[name] for name in ("steps", "made", "processor", "python", "compiler")},
        count=len(numbers["programs"]),
        names="; ".join(numbers["programs"]),
        handed=words,
    )
    return HEAD + "\n".join(format_row(row, base) for row in rows) + "\n" + foot
