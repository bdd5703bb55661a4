"""The section of the benchmark on fits: what derivatives cost, and whole fits of measured cycles.

What: residuals of five records with the derivatives in twelve directions, against the residuals
alone, that is one run of every record; a wire heated by current, and an isobaric test of the law
`lagoudas`. Derivatives are judged by central differences in one direction. Whole fits are those of
`examples/` on the isobaric cycles of Flexinol, compiled before they are timed, judged by the error
of strain at 172 MPa, which they do not see; without the measurements they are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.harness import Candidate, measure
from benchmarks.process import ROOT
from benchmarks.report import Table
from benchmarks.sections import Options, rows_of, section
from martensite.fit.api import fit_logs
from martensite.fit.experiment import Experiment
from martensite.fit.problem import Problem, build_problem
from martensite.logs import datasets
from martensite.scenario.scenario import read_scenario
from martensite.signals.records import Record

WIRE = """
[element]
kind = "wire"
material = "{material}"
law = {{ {law} }}
diameter = "0.381 mm"
length = "100 mm"
resistance = {{ kind = "mixture", rho_A = "8.4e-7 ohm*m", rho_M = "9.2e-7 ohm*m" }}
"""
HEATED = """
[environment]
temperature = "25 degC"
cooling = { kind = "constant", h = "70 W/m^2/K" }

[mechanism]
kind = "dead-weight"
mass = "{level} kg"

[drive]
kind = "current"
waveform = { kind = "triangle", low = "0 A", high = "2.2 A", frequency = "0.02 Hz" }

[run]
duration = "100 s"
"""
ISOBARIC = """
[mechanism]
kind = "testing-machine"
control = "stress"
section = "0.114 mm^2"

[signals.command]
kind = "constant"
level = "{level} MPa"

[drive]
kind = "temperature"
waveform = { kind = "triangle", low = "-20 degC", high = "130 degC", frequency = "0.01 Hz" }

[run]
duration = "100 s"
"""
BOTH = ("A_s", "A_f", "M_s", "M_f", "C_A", "C_M", "E_A", "E_M")
CASES = {
    "wire, liang-rogers, heated by current": (
        WIRE.format(material="flexinol-90", law='kind = "liang-rogers", modulus = "mixture"') + HEATED,
        (0.6, 0.8, 1.0, 1.2, 1.4),
        (*BOTH, "eps_L", "cooling.h", "heat_capacity", "latent_heat"),
    ),
    "wire, lagoudas, isobaric": (
        WIRE.format(material="niti-lagoudas", law='kind = "lagoudas"') + ISOBARIC,
        (50, 80, 110, 140, 170),
        (*BOTH, "H_sat", "H_k=1e-3..0.1 1/MPa", "n_1", "n_3"),
    ),
}
ROWS, STEP = 501, 0.1
WHOLE = ("fit_isobaric.toml", "fit_flexinol_trained.toml")
CYCLE = "flexinol-isobaric/isobaric_172MPa.txt"


def five_records(text: str, levels: Sequence[float], names: Sequence[str]) -> Problem:
    """Five records and twelve free parameters; what was measured does not matter."""
    from martensite.fit.free_parameters import read_ranges

    times = np.linspace(0.0, 100.0, ROWS)
    columns = {"time": times.tolist(), "strain": (0.04 * np.sin(times)).tolist()}
    record = Record("test", columns, {"time": "s", "strain": "1"})
    scenarios = [read_scenario(text.replace("{level}", str(level))) for level in levels]
    made = [
        Experiment(str(level), one.system, one.waveform, record, {"strain": "strain"}, step=STEP)
        for level, one in zip(levels, scenarios, strict=True)
    ]
    return build_problem(made, read_ranges(list(names), [one.system for one in made]))


def slopes_error(task: Problem) -> Any:
    """How far the derivatives in the first direction are from central differences."""
    u, shift = task.start, 1e-5
    above, below = u.copy(), u.copy()
    above[0] += shift
    below[0] -= shift
    pair = [task.evaluate(point) for point in (above, below)]
    assert pair[0] is not None
    assert pair[1] is not None
    exact = (pair[0].residuals - pair[1].residuals) / (2.0 * shift)

    def error(found: Any) -> float:
        return float(np.abs(found.jacobian[:, 0] - exact).max() / np.abs(exact).max())

    return error


@section
def derivatives(options: Options) -> list[Table]:
    """Twelve directions beside a run of all five records."""
    tables: list[Table] = []
    for name, case in CASES.items():
        task = five_records(*case)
        runs = [
            Candidate("residuals", lambda task=task: task.evaluate(task.start)),
            Candidate(
                "residuals and 12 derivatives",
                lambda task=task: task.evaluate(task.start, slopes=True),
                slopes_error(task),
            ),
        ]
        rows = rows_of(measure(runs, options.repeats, "residuals"), "ms", 1e3)
        note = f"5 records of {ROWS} rows. Ratio to one run of each."
        tables.append(Table(f"Derivatives: {name}", rows, note))
    return tables


@section
def fits(options: Options) -> list[Table]:
    """Whole fits of three measured cycles, judged on the fourth."""
    if not datasets.is_here(CYCLE):
        return []

    def held_out(found: Any) -> float:
        return next(one.rms for one in found.scores if one.part == "held-out")

    runs = [Candidate(name, lambda name=name: fit_logs(ROOT / "examples" / name), held_out) for name in WHOLE]
    rows = rows_of(measure(runs, min(options.repeats, 3), WHOLE[0]), "s", 1.0)
    note = "err: strain at 172 MPa, which the fit does not see. Compiled before."
    return [Table("Fits of Flexinol, 0.381 mm", rows, note)]
