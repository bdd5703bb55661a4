"""The words of the benchmark page."""

from __future__ import annotations

from typing import NamedTuple


class Words(NamedTuple):
    """Title and text of a part, and what is drawn in it."""

    title: str
    text: str
    figures: tuple[str, ...] = ()


INTRODUCTION = """
## Comparison with other programs

These benchmarks compare martensite with other programs. They report **ratios only**, because a time depends on the
computer and on the day. One command writes this section and its drawings from [the numbers](benchmarks/numbers.json)
of one run.

| term | definition |
| --- | --- |
| time | CPU time of all threads. Linear algebra uses one thread. Compilation and first calls do not count. |
| round | All candidates of a table run one after another, so that a change of the load affects all of them. |
| ratio | Median over the rounds of the ratio to the base within a round. The base has the ratio 1; above 1 is slower. |
| spread | Interquartile range of the CPU time, divided by its median. |
| error | RMS difference of the displacement to a converged reference, divided by its range. |
| equal error | Every engine uses its coarsest setting that meets the error. |
| problem A | A Liang–Rogers wire on a spring, heated by a voltage for 60 s (`benchmarks/problem_a.py`). |
| problem B | A Müller–Achenbach–Seelecke wire on a spring, heated by a power for 20 s (`benchmarks/problem_b.py`). |

The parameters of both problems are chosen for this project; they describe no experiment. General solvers integrate
the rate form of A, which restarts a transformation when it reverses. martensite continues where the transformation
stopped. Each engine is compared with the converged solution of its form. The right-hand side of LSODA in C is C.
Right-hand sides of SciPy and SUNDIALS are Python functions. The right-hand sides of diffrax are JAX functions.
"""

PARTS = {
    "wire": Words(
        "One run of problem A at equal error",
        """
Base: the first row, LSODA in C with a right-hand side in C, as numbalsoda calls it. *simulate* is the call of a user
with all outputs and an error bound, for which the run is integrated two or three times; the other programs report no
bound. *C alone* is one integration with prepared arrays.
""",
    ),
    "rates": Words(
        "One run of problem B at equal error",
        "Base and rows as for problem A. The solvers restart at the kinks of the power.",
    ),
    "calls": Words(
        "Batches as users call them",
        """
Every run has ten individual parameters. CPU time of a run, one thread; base: the first row. *simulate* stands here
for `simulate_batch`. *C alone* is one integration of each run in batches with prepared arrays. LSODA runs 16 wires,
one after another. Errors are those of the worst of four runs.
""",
    ),
    "batches": Words(
        "Batches",
        """
Problem A in steps of 20 ms, where every run has ten individual parameters, and the finger of `examples/finger.toml`
with three laws. Base: C in batches, one thread, in the same table. *Runs per second, relative* is by wall clock. For
the wire it is relative to the base in the largest batch, for the finger to the base. LSODA computes fewer runs, one
after another. Errors of the finger are differences to the same runs as single runs.

The last table compares the arithmetic of one core, measured by loops in C, with the arithmetic of a batch. Every
operation counts as one, including elementary functions. Values above 100 % of division mean
that the compiler combined several divisions.
""",
        ("throughput",),
    ),
    "sweep": Words(
        "Sweeps from one run to a million",
        """
`martensite sweep` of a wire with a short pulse (100 steps) into a store on disk. Four measures are stored for every
run. Each sweep uses one thread in a separate process. No row is extrapolated. Base: the CPU time of a run in the
sweep of 1,000. In small sweeps the start-up dominates. Memory is the peak of the process, divided by its peak before
the sweep.
""",
        ("cost", "memory"),
    ),
    "slopes": Words(
        "Gradient for ten parameters",
        """
Problem A: gradient of the squared distance to another run. martensite uses forward derivatives in C, diffrax uses
forward mode, and the other engines use finite differences. Base: martensite. Errors are relative errors of the
gradient at the usual setting of each engine.
""",
    ),
    "laws": Words(
        "Constitutive law alone",
        """
A thermal loop of 1,000 steps at 200 MPa with the law of Lagoudas, one parameter set and linear hardening. Base:
martensite in C, one loop of `material_point`. The error is the largest difference of strain to the same path in
Python, divided by its range. [simcoon](https://github.com/3MAH/simcoon) is three-dimensional and has other corners,
so it cannot agree exactly. The model core of [SMA_REACT](https://github.com/maestrolab/SMA_REACT) has the same
equations. The loop starts cold.
""",
    ),
    "control": Words(
        "One step of a control loop",
        """
The reference of this table is the control period of 20 ms. The values are wall-clock times of single calls from
Python, as fractions of the period: the median, and the 99 % and 99.9 % percentiles. The percentiles include other
work on the computer.
""",
    ),
}

COLUMNS = {
    "err": "error",
    "rate": "runs per second, relative",
    "ratio": "CPU time, ratio",
    "memory": "memory, ratio",
    "median": "median",
    "p99": "99 %",
    "p99.9": "99.9 %",
}

ALT = {
    "cost": "CPU time per run against the number of runs, both axes logarithmic",
    "memory": "Peak memory against the number of runs",
    "throughput": "Runs per second against the batch size, both axes logarithmic",
}
CAPTIONS = {
    "cost": "Figure: The CPU time per run falls until about 1,000 runs, because the start-up is shared.",
    "memory": "Figure: The peak memory of the whole process, relative to the memory before the sweep.",
    "throughput": "Figure: Batches of 64 runs and more are several times faster than single runs.",
}

CLOSING = """
### Repeat the benchmarks

The build of the documentation does not run the benchmarks. In a checkout with the extra `bench`, on an idle computer:

```text
{command}
```

| option | effect |
| --- | --- |
| `--quick` | fewer engines and smaller batches |
| `--only` | run some parts and keep the others |
| `--from docs/reference/benchmarks/numbers.json` | write this section from existing numbers |

`MARTENSITE_SIMCOON_PYTHON` is the interpreter of an environment with simcoon. `MARTENSITE_SMA_REACT` is a checkout of
SMA_REACT, which is on no package index. Both run in separate processes. `python -m benchmarks` prints all
sections with times.
"""
