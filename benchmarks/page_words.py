"""The words of the benchmark page."""

from __future__ import annotations

from typing import NamedTuple


class Words(NamedTuple):
    """Title and text of a part, and what is drawn in it."""

    title: str
    text: str
    figures: tuple[str, ...] = ()


INTRODUCTION = """
# Benchmarks

How fast martensite is beside other programs, as **ratios only**: a time belongs to one machine on
one day, a ratio of two times taken side by side says more. This page and its drawings are written
by a command from [the numbers](benchmarks/numbers.json) of one run; none is set by hand.

**How it is measured.** Every round runs all candidates of a table one after another, so that a
change of the load of the machine meets all of them. Time is CPU time, user and system, of all
threads; linear algebra has one. A ratio is the median over the rounds of the ratios within a round;
the spread is the distance of the quartiles of the CPU time over its median. Compiling and first
calls are not in it. Above 1 a ratio means: slower than the base, which is the row with ratio 1.

**What an error is.** In the tables of whole runs, the rms difference of the displacement to a
converged reference, over its range. At *equal error*, every engine runs at the coarsest of its
settings that is within the error: an engine that takes its time to be exact does not lose by it.

**What is compared.** Problem A is a Liang–Rogers wire on a spring, heated by a voltage for 60 s.
Problem B is a Müller–Achenbach–Seelecke wire on a spring, heated by a power for 20 s, whose
rates change by many decades within a step. Both are written down in `benchmarks/problem_a.py` and
`benchmarks/problem_b.py`. The numbers of both were chosen for this project: no experiment is in
them. General solvers integrate the rate form of A, which begins a transformation anew when it
turns (`restart`), while the march of this package goes on where it stopped (`resume`): each is
judged by the converged solution of the form that it solves. Right-hand sides of SciPy and SUNDIALS
are Python, as their users write them; those of diffrax are JAX.
"""

PARTS = {
    "wire": Words("One run of problem A at equal error", "Base: martensite in C, one run, called from Python."),
    "rates": Words(
        "One run of problem B at equal error",
        "Base: martensite in C. The solvers begin anew at the kinks of the power.",
    ),
    "batches": Words(
        "Many runs at once",
        """
Problem A in steps of 20 ms, every run with ten parameters of its own, and the finger of
`examples/finger.toml` with three laws. Base: C in blocks of lanes, one thread, in the same
table. *Runs per second* is by the clock on the wall, as a share: for the wire of the base in the
largest batch, for the finger of the base. LSODA makes its runs one after another, and fewer of
them. Errors of the finger are those to the same runs one by one.

The last table sets the arithmetic of one core, measured by loops in C that do nothing else,
against what the lanes do: every operation counts as one, an elementary function too. Above 100 %
of division means that some divisions as written were done at once.
""",
        ("throughput",),
    ),
    "sweep": Words(
        "From one run to a million",
        """
A sweep as `martensite sweep` makes it, of a wire with a short pulse (100 steps), into a store on
the disk, four numbers kept of every run; one thread, each sweep in a process of its own. Every
row was run, none is continued from another. Base: the CPU time of a run in the sweep of 1,000;
in small sweeps it is the beginning that costs. Memory is the peak of the process over its peak
before the sweep.
""",
        ("cost", "memory"),
    ),
    "slopes": Words(
        "A gradient of ten parameters",
        """
Problem A, the squared distance to another run by ten parameters. martensite: forward derivatives in
C; diffrax: forward mode; the others: differences of runs. Base: martensite. Errors are those of the gradient,
relative, at the usual setting of each engine.
""",
    ),
    "laws": Words(
        "A law alone",
        """
A loop of 1,000 steps in temperature at 200 MPa, with the law of Lagoudas and one set of numbers,
linear hardening. Base: martensite in C, one loop as `material_point` makes it. The error is the
largest difference of strain to the same path on floats, over its range. [simcoon](https://github.com/3MAH/simcoon)
has three dimensions and corners of its own, so that it cannot agree exactly; the model core of
[SMA_REACT](https://github.com/maestrolab/SMA_REACT) has the same equations. It begins cold.
""",
    ),
    "control": Words(
        "One step of a control loop",
        """
Here a time matters that is not another program's: the period of 20 ms. Numbers are shares of it,
by the clock on the wall, of single calls from Python: median, and the calls of which one in a
hundred and one in a thousand is slower. What else the machine does is in the latter two.
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
    "cost": "CPU time of a run against the number of runs, both axes logarithmic",
    "memory": "Peak memory against the number of runs",
    "throughput": "Runs per second against the size of the batch, both axes logarithmic",
}

CLOSING = """
## To make this page again

It is not made when the documentation is built, as that would take machine time. In a checkout with
the extra `bench`, on a machine that does nothing else:

```text
{command}
```

`--quick` takes fewer engines and smaller batches, `--only` makes some parts again and keeps the
others, and `--from docs/reference/benchmarks/numbers.json` writes the page again from its numbers,
which a test compares with what is committed. `MARTENSITE_SIMCOON_PYTHON` names an interpreter that
has simcoon, `MARTENSITE_SMA_REACT` a checkout of SMA_REACT, which is on no package index; both run
in processes of their own. All sections, with times, are printed by `python -m benchmarks`.
"""
