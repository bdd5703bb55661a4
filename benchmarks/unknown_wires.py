"""Self-sensing on wires that nobody measured: hundreds of wires side by side, in one batch of loops in C.

The loop is that of `examples/self_sensing.toml`. Its reference is a sine of 1 to 6 mm at 0.05 Hz, after the
calibration and half a minute at 1 mm. Wires differ from the sheet by uniform draws: resistivities ±10 %, both by one
factor or each by its own; transformation temperatures ±5 K, those on heating and those on cooling each by their own;
diameter ±3 %; surroundings ±10 K; the film coefficient by a factor of 0.5 to 2, uniform in its logarithm. Readings
have 1 % of noise. A draught can multiply the film coefficient from 130 s on.

A wire holds if the rms of position less reference is within 5 % of the 5 mm asked for: over all of the sine, or, with a
draught, over three periods from a minute after its start. The loop reports a miss by the rule of
`martensite.control.loop.miss_rule`, without knowing the position.

    python -m benchmarks.unknown_wires [--wires 200] [--own-resistivities] [--before] [--guard fixed]
    python -m benchmarks.unknown_wires --study [--wires 200] [--seed 5800]

`--study` runs both kinds of resistivities with draughts of 1, 0.5, 1.3 and 2, and compares with a position sensor.
Observers were tuned on the wires of seed `TUNED_ON` and the nine after it, and are judged on those from `JUDGED_ON` on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.control.checks.base import Checks
from martensite.control.faults.plant import Draught
from martensite.control.loop.bench import Bench
from martensite.control.loop.miss_rule import SETTLING, Expectation, expect_error
from martensite.control.loop.names import NOISE
from martensite.control.loop.parts import Controllers, FaultTable, Observers, Sensors
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.supervisors.from_plant import build_thermal_guard
from martensite.control.supervisors.guard import Guard
from martensite.scenario.examples import EXAMPLES
from martensite.scenario.scenario import load
from martensite.simulate.lanes import Lanes

Numbers = NDArray[np.float64]
TUNED_ON, JUDGED_ON = 11, 5800
LOW, HIGH = 1e-3, 6e-3
"""Of the reference [m]."""
CALIBRATION = 80.0
"""Duration of the calibration, during which the controller waits [s]."""
PERIODS = 3
"""Periods of the sine, which begins when the estimates have settled."""
WITHIN = 0.05
DRAUGHT, RECOVERY = 20.0, 60.0
"""Start of a draught after the start of the sine, and time to recover from it [s]."""
DRAUGHTS = (1.0, 0.5, 1.3, 2.0)
CONTRAST = 0.06
"""Difference of the two resistivities from which the study counts wires separately."""
CHUNK = 250
"""Periods that are kept at once."""
POSITION, CONFIDENCE = "estimated.position", "estimated.confidence"


class Task(NamedTuple):
    """What is asked of a wire."""

    supply: float
    """[V]"""
    frequency: float
    """Of the sine [Hz]."""


FAIR, ORIGINAL = Task(7.0, 0.05), Task(5.0, 0.1)


@dataclass(frozen=True)
class UnknownWires:
    """What became of every wire."""

    error: Numbers
    """Rms of position less reference, as a share of the span."""
    estimate: Numbers
    """Rms of estimate less position, as a share of the span."""
    hottest: Numbers
    """Highest temperature, calibration and all [K]."""
    limit: float
    """Highest temperature allowed [K]."""
    expected: Expectation
    """Error that the loop expects; without an observer, its true error at a confidence of 1."""

    @property
    def holds(self) -> NDArray[np.bool_]:
        """Whether the error is within 5 % of the span."""
        return self.error <= WITHIN

    @property
    def says_missed(self) -> NDArray[np.bool_]:
        """Whether it says that it misses, without knowing the position."""
        return self.expected.misses

    def describe(self) -> str:
        """One line."""
        missed, count = ~self.holds, len(self.error)
        said = f"{int(self.says_missed[missed].sum())} of {int(missed.sum())} that miss say so"
        false = (
            f"{100.0 * float(self.says_missed[~missed].mean()) if self.holds.any() else 0.0:.0f} % of the others too"
        )
        return (
            f"{100.0 * self.holds.mean():5.1f} % of {count} within 5 % (median {100.0 * np.median(self.error):.1f} %, "
            f"estimates {100.0 * np.median(self.estimate):.1f} %), {said}, {false}; "
            f"hottest {self.hottest.max() - 273.15:.0f} °C, {int((self.hottest > self.limit).sum())} above the limit"
        )


def draw_wires(plant: AbstractSystem, count: int, seed: int, *, own_resistivities: bool = False) -> dict[str, Numbers]:
    """Parameters of random wires, by path, each of shape (count,).

    Args:
        plant: the wire of the sheet.
        count: how many.
        seed: of the draws.
        own_resistivities: each of the two phases has a factor of its own, else both have the same one.
    """
    rng = np.random.default_rng(seed)

    def between(half: float) -> Numbers:
        return rng.uniform(-half, half, count)

    austenite, martensite, heating, cooling = between(0.1), between(0.1), between(5.0), between(5.0)
    film, diameter, around = 2.0 ** between(1.0), between(0.03), between(10.0)
    martensite = martensite if own_resistivities else austenite
    factors = {"rho_A": 1.0 + austenite, "rho_M": 1.0 + martensite, "cooling.h": film, "diameter": 1.0 + diameter}
    shifts = {"A_s": heating, "A_f": heating, "M_s": cooling, "M_f": cooling, "environment.temperature": around}
    found = {plant.resolve(name): plant.value_of(name) * x for name, x in factors.items()}
    return found | {plant.resolve(name): plant.value_of(name) + x for name, x in shifts.items()}


GUARDS = ("estimated", "fixed", "none")
HOTTER, LEAST = 10.0, 0.5
"""Hottest surroundings above those of the sheet [K], least film coefficient over that of the sheet."""


def build_guard(sheet: AbstractSystem, kind: str = "estimated") -> Guard | None:
    """A bound on the temperature for a wire of a sheet, whose answer is `limit`.

    Args:
        sheet: what is known.
        kind: `estimated`: the heat loss follows `estimated.least_cooling`; `fixed`: it is the least; `none`.
    """
    if kind == "none":
        return None
    hottest = sheet.value_of("environment.temperature") + HOTTER
    guard = build_thermal_guard(sheet, hottest=hottest, least_cooling=LEAST if kind == "fixed" else 1.0, answer="limit")
    if kind == "fixed":
        return guard
    ((name, bound),) = guard.checks.members().items()
    return guard.with_parts(checks=Checks(**{name: bound.with_parts(cooling="estimated.least_cooling")}))


def build_bench(observer: str = "self-sensing", task: Task = FAIR, guard: str = "estimated") -> Bench:
    """The loop of the example at the values of the sheet.

    Args:
        observer: `self-sensing`; `extended` or `drifting`, as it was before; `none` for the position itself.
        task: what is asked for.
        guard: one of `GUARDS`; without estimates of `self-sensing` there is none.
    """
    scenario = load(EXAMPLES / "self_sensing.toml")
    bench: Any = scenario.bench
    (own,) = bench.observers.members().values()
    plant = own.model.with_values({"supply": task.supply})
    bench = bench.with_parts(faults=FaultTable(fan=Draught(factor=1.0, start=CALIBRATION + SETTLING + DRAUGHT)))
    (drive,) = bench.controllers.members()
    controller = bench.controllers.members()[drive]
    if observer == "none":
        loop = Controllers(**{drive: controller.with_parts(measured="position")})
        free = {"sensors": Sensors(), "observers": Observers(), "supervisor": None}
        return bench.with_parts(plant=plant, controllers=loop, **free)
    drifting = ("resistance.rho_A", "resistance.rho_M", "cooling.h") if observer == "drifting" else ()
    filters = {
        "self-sensing": own.with_parts(model=plant),
        "extended": ExtendedKalman(model=plant),
        "drifting": ExtendedKalman(model=plant, drifting=drifting, first_drift=0.05),
    }
    supervisor = build_guard(plant, guard if observer == "self-sensing" else "none")
    return bench.with_parts(plant=plant, observers=Observers(wire=filters[observer]), supervisor=supervisor)


def run_unknown_wires(
    bench: Bench,
    wires: Mapping[str, Numbers],
    *,
    frequency: float = FAIR.frequency,
    draught: float = 1.0,
    seed: int = 0,
) -> UnknownWires:
    """Run a loop on many wires side by side.

    Args:
        bench: with one controller, for the wire of the sheet.
        wires: parameters of its plant by path, as of `draw_wires`.
        frequency: of the sine [Hz].
        draught: factor of the film coefficient from `DRAUGHT` after the start of the sine on.
        seed: of the noise.
    """
    begin, period = CALIBRATION + SETTLING, bench.period
    judged = begin if draught == 1.0 else begin + DRAUGHT + RECOVERY
    times = period * np.arange(1, round((judged + PERIODS / frequency) / period) + 1)
    reference = LOW + 0.5 * (HIGH - LOW) * (1.0 - np.cos(2.0 * np.pi * frequency * np.maximum(times - begin, 0.0)))
    values = {"faults.fan.factor": draught} | {f"plant.{path}": x for path, x in wires.items()}
    lanes = Lanes(bench, len(next(iter(wires.values()))), values)
    names = [
        name for name in ("position", "temperature", POSITION, POSITION + "_std", CONFIDENCE) if name in lanes.names
    ]
    rows = [lanes.names.index(name) for name in names]
    rng, kept = np.random.default_rng(seed), list[Numbers]()
    lanes.reset(np.where(np.array(lanes.drives) == "reference", LOW, 0.0)[:, None])
    for first in range(0, len(times), CHUNK):
        asked = reference[first : first + CHUNK]
        signals = np.zeros((len(asked), len(lanes.drives), lanes.lanes))
        for k, name in enumerate(lanes.drives):
            if name.startswith(NOISE):
                signals[:, k] = rng.standard_normal((len(asked), lanes.lanes))
        signals[:, lanes.drives.index("reference")] = asked[:, None]
        kept.append(lanes.advance(signals, period)[:, rows])
    found = dict(zip(names, np.moveaxis(np.concatenate(kept), 1, 0), strict=True))
    (limits,) = [one.element.limits for one in bench.plant.actuators().values()]
    return _judge_wires(found, times > judged, reference[:, None], limits.temperature_limit)


def _judge_wires(found: Mapping[str, Numbers], counts: Any, reference: Numbers, limit: float) -> UnknownWires:
    span = HIGH - LOW

    def measure(x: Numbers) -> Numbers:
        return np.sqrt(np.mean(x[counts] ** 2, axis=0)) / span

    position = found["position"]
    guess = found.get(POSITION, position)
    spread, trust = (
        found.get(name, np.full_like(position, x)) for name, x in ((POSITION + "_std", 0.0), (CONFIDENCE, 1.0))
    )
    expected = expect_error(guess[counts], spread[counts], reference[counts], trust[counts])
    return UnknownWires(
        measure(position - reference), measure(guess - position), found["temperature"].max(axis=0), limit, expected
    )


def run_study(count: int, seed: int) -> list[str]:
    """Return the rows of a table in Markdown: both kinds of resistivities, with and without draughts."""
    rows = [
        f"| resistivities | draught | position sensor | self-sensing | phases differ by {100 * CONTRAST:.0f} % | peak "
        "temperature | reported misses | false warnings |",
        "| --- " * 8 + "|",
    ]
    benches = [build_bench(name) for name in ("none", "self-sensing")]
    for own, title in ((False, "one factor"), (True, "own factors")):
        wires = draw_wires(benches[0].plant, count, seed, own_resistivities=own)
        (austenite,), (martensite,) = ([x for p, x in wires.items() if p.endswith(n)] for n in ("rho_A", "rho_M"))
        differ = np.abs(austenite / martensite - 1.0) >= CONTRAST
        for draught in DRAUGHTS:
            sensed, found = (run_unknown_wires(one, wires, draught=draught, seed=seed) for one in benches)
            said, holds = found.says_missed, found.holds
            above = int((found.hottest > found.limit).sum())
            cells = (
                *(title, f"{draught:g}", f"{100 * sensed.holds.mean():.0f} %", f"{100 * holds.mean():.0f} %"),
                *(f"{100 * holds[differ].mean():.0f} %", f"{found.hottest.max() - 273.15:.0f} °C, {above} above"),
                *(f"{said[~holds].sum()} of {(~holds).sum()}", f"{said[holds].sum()} of {holds.sum()}"),
            )
            rows.append(f"| {' | '.join(cells)} |")
    return rows


def main(
    wires: int = 200,
    own_resistivities: bool = False,
    before: bool = False,
    seed: int = JUDGED_ON,
    guard: str = GUARDS[0],
    study: bool = False,
) -> None:
    """Judge the observers on random wires."""
    if study:
        typer.echo("\n".join(run_study(wires, seed)))
        return
    for task in (FAIR, ORIGINAL):
        for observer in ("none", *(("extended", "drifting") if before else ()), "self-sensing"):
            bench = build_bench(observer, task, guard)
            drawn = draw_wires(bench.plant, wires, seed, own_resistivities=own_resistivities)
            found = run_unknown_wires(bench, drawn, frequency=task.frequency)
            typer.echo(f"{task.supply:g} V, {task.frequency:g} Hz, {observer:12} {found.describe()}")


if __name__ == "__main__":
    typer.run(main)
