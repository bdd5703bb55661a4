"""Runs many cases and writes the page of the laboratory.

In the folder `tests`: `python -m laboratory accuracy`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from multiprocessing import Pool
from pathlib import Path
from statistics import median

from laboratory.layers import make_layers
from laboratory.measures import MeasureRecord, repeat_worst, run_trials
from laboratory.scenarios import DRIVES, JUDGED, SAMPLES, Scenario, make_scenario, true_error
from martensite.simulate.api import simulate

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/developer/accuracy-tests.md"
NUMBERS = ROOT / "docs/developer/accuracy-tests.json"
TOLERANCES = (1e-3, 1e-4, 1e-5)
RATES = "any, law of rates"
CLOSER = 0.25
"""Longest step of a repeated reference, in longest steps of the first."""
CASES, SCENARIOS = 1400, 1100
"""Random wires beside other equations, and scenarios of measures, of a whole run."""


@dataclass(frozen=True)
class Outcome:
    """What a case showed."""

    seed: int
    drive: str
    tolerance: float
    true: float
    """Error, as a share of range."""
    claimed: float
    """Accuracy that was reported."""
    steps: int

    @property
    def ratio(self) -> float:
        """True error over the claimed one."""
        return self.true / self.claimed


def try_case(seed: int, tolerance: float, drive: str | None = None) -> Outcome:
    """A scenario without rates against its reference."""
    return _compare(lambda: make_scenario(seed, drive), seed, tolerance)


def try_layers(seed: int, tolerance: float, drive: str | None = None) -> Outcome:
    """A scenario of layers that jump at rates against its reference."""
    found = _compare(lambda: make_layers(seed, drive), seed, tolerance)
    return replace(found, drive=RATES)


def _compare(make: Callable[[], Scenario], seed: int, tolerance: float) -> Outcome:
    case = make()
    meant = case.equations.run(case.times)
    found = simulate(case.system, case.waveform, case.duration, tolerance=tolerance, samples=SAMPLES, runtime="c")
    assert not found.status.failed, (seed, found.warnings)
    assert found.accuracy is not None
    true = true_error([found[name] for name in JUDGED], meant)
    if true > found.accuracy:  # the reference may miss a touch between two of its steps
        again = make()
        again.equations.longest *= CLOSER
        true = true_error([found[name] for name in JUDGED], again.equations.run(again.times))
    return Outcome(seed, case.name.split(", ")[-1], tolerance, true, found.accuracy, found.steps)


def _try(seed: int) -> Outcome:
    case = try_layers if seed % 4 == 3 else try_case
    return case(seed, TOLERANCES[seed % len(TOLERANCES)], DRIVES[seed % len(DRIVES)])


def quantile(ratios: Iterable[float], share: float) -> float:
    """The smallest one that so many do not exceed."""
    ordered = sorted(ratios)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def page(outcomes: list[Outcome], measured: MeasureRecord) -> str:
    """The page, in Markdown."""
    rows = [
        "| drive | cases | worst true error / tolerance | true / claimed: median | 99 % | worst | steps, median |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for drive in (*DRIVES, RATES, "all"):
        some = [one for one in outcomes if drive in (one.drive, "all")]
        if not some:
            continue
        ratios = [one.ratio for one in some]
        worst = max(one.true / one.tolerance for one in some)
        cells = (
            drive,
            str(len(some)),
            f"{worst:.2f}",
            f"{median(ratios):.2f}",
            f"{quantile(ratios, 0.99):.2f}",
            f"{max(ratios):.2f}",
            f"{median(one.steps for one in some):.0f}",
        )
        rows.append("| " + " | ".join(cells) + " |")
    return HEAD + "\n".join(rows) + "\n" + measured.page()


HEAD = """# Accuracy tests

This page shows how often the accuracy that a run reports bounds its true error.

Random wires with random drives run in C with tolerances of 1e-3, 1e-4 and 1e-5. The wires have cosine and exponential
kinetics; voltage, current or power; a spring or a weight. The reference is a system of ordinary differential
equations that shares no code with the package; SciPy integrates it from kink to kink to 1e-10. The error is the
largest error of temperature, martensite fraction and stress at 101 samples, relative to their ranges. *Claimed* is
the reported accuracy. If the error exceeds it, the reference is repeated in steps of at most a quarter, because a
reference can miss a touch of a strip between two steps.

| drive | meaning |
| --- | --- |
| round sine | periods and durations are round numbers |
| pulses | 1 ms to 10 s, up to a hundred times the power that keeps the wire hot |
| pwm | 10 to 100 Hz |
| fast pwm | 100 Hz to 10 kHz |
| any, law of rates | a rate-dependent law (`mas`) with all of these drives; Radau integrates the reference |

## Temperature, fraction and stress

"""


def write_measures(share: float, processes: int = 1) -> None:
    """Run a share of the scenarios of measures, and write the page."""
    run_trials(round(share * SCENARIOS), processes).write()
    write_page()


def repeat(_share: float, _processes: int = 1) -> None:
    """Repeat the scenarios of the page with an error far above its bound, and write the page."""
    repeat_worst().write()
    write_page()


def write_wires(share: float, processes: int = 1) -> None:
    """Run a share of the random wires, and write the page."""
    with Pool(processes) as pool:
        outcomes = sorted(pool.imap_unordered(_try, range(round(share * CASES))), key=lambda one: one.seed)
    NUMBERS.write_text(json.dumps([asdict(one) for one in outcomes], indent=0) + "\n", encoding="utf-8")
    write_page()


def write(share: float, processes: int = 1) -> None:
    """Run both, and write the page."""
    write_measures(share, processes)
    write_wires(share, processes)


def write_page() -> None:
    """Write the page of what was found."""
    PAGE.write_text(page(read_outcomes(), MeasureRecord.read()), encoding="utf-8")


def read_outcomes() -> list[Outcome]:
    """The outcomes of the page."""
    return [Outcome(**row) for row in json.loads(NUMBERS.read_text(encoding="utf-8"))]
