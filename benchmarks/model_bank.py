"""`python -m benchmarks.model_bank`: how soon a bank of models loses its trust, and how hot the wire gets.

A wire follows a sine without a position sensor (`examples/closed_loop_sensorless.toml`). At some moment something is
no longer as its model has it. Told is the time until the confidence is below one half, beside the time after which a
detector that knows the moment, and both courses of the resistance without noise, is sure to 7 standard deviations:
sooner nothing can be seen at all. Wires are run without a guard and with one; an hour without faults counts false
alarms.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from martensite.control import simulate_bench
from martensite.control.loop.bench import Bench
from martensite.control.loop.parts import Controllers, FaultTable, Observers
from martensite.scenario.scenario import load
from martensite.signals.held import Held

EXAMPLE = Path(__file__).parents[1] / "examples" / "closed_loop_sensorless.toml"
LATE = 1e6
SURE = 7.0
"""Standard deviations."""
FAULTS = {"fan": {"kind": "draught"}, "slack": {"kind": "slack", "length": "1 mm"}, "clamped": {"kind": "clamped"}}
CASES: dict[str, tuple[str, dict[str, float]]] = {
    "fan, h × 2": ("fan", {"faults.fan.factor": 2.0}),
    "fan, h × 3": ("fan", {"faults.fan.factor": 3.0}),
    "slack of 1 %": ("slack", {"faults.slack.length": 2.5e-3}),
    "slack of 2 %": ("slack", {"faults.slack.length": 5e-3}),
    "clamped": ("clamped", {}),
}
ONSETS = (12.0, 13.0, 14.0, 16.0, 17.0, 18.0)
"""While the reference rises, and while it falls [s]; it turns at 10, 15 and 20."""
SEEDS = range(500, 508)
LIMIT = {
    "supervisor.kind": "guard",
    "supervisor.from_plant": {"temperature_limit": "130 degC"},
    "supervisor.checks.trust.kind": "low-confidence",
}


def build_bench(guarded: bool, observer: str = "model-bank") -> Bench:
    """The example with a bank of models, and faults that never begin."""
    faults: dict[str, Any] = {f"faults.{name}": {**given, "start": f"{LATE} s"} for name, given in FAULTS.items()}
    faults["faults.fan"]["factor"] = 2.0
    bench = load(
        EXAMPLE, {"observer.kind": observer, **faults, **(LIMIT if guarded else {"supervisor.kind": "none"})}
    ).bench
    assert bench is not None
    return bench


def run_bench(bench: Bench, seconds: float, seed: int | None, **options: Any) -> dict[str, Any]:
    """Columns of a run."""
    found = simulate_bench(bench, seconds, seed=seed, **options)
    return {"times": np.array(found.times)} | {name: np.array(column) for name, column in found.columns.items()}


def find_delay(run: Mapping[str, Any], onset: float) -> float:
    """Time until the confidence is below one half [s]; infinite if it never is."""
    low = (run["times"] >= onset) & (run["estimated.confidence"] < 0.5)
    return float(run["times"][low][0] - onset) if low.any() else np.inf


def find_visible(run: Mapping[str, Any], open_bench: Bench, onset: float) -> float:
    """Time after which it can be seen at all, given the same signals [s]."""
    duty = Held(values=tuple(run["wanted"].tolist()), frequency=round(1.0 / open_bench.period))
    sound = run_bench(open_bench, float(run["times"][-1]), None, waveforms={"drive": duty})
    apart = (run["resistance"] / sound["resistance"] - 1.0) / 0.01
    sure = np.sqrt(np.cumsum(np.where(run["times"] >= onset, apart**2, 0.0))) >= SURE
    return float(run["times"][sure][0] - onset) if sure.any() else np.inf


def main() -> None:
    """Print the table."""
    free, guarded = build_bench(False), build_bench(True)
    alone = free.with_parts(observers=Observers(), controllers=Controllers(), faults=FaultTable())
    print(f"{'':14} {'seen after':>16} {'possible after':>16} {'within 2 s':>10} {'hottest':>8} {'guarded':>8}")
    for label, (fault, numbers) in CASES.items():
        rows = []
        for onset in ONSETS:
            at = numbers | {f"faults.{fault}.start": onset}
            for seed in SEEDS:
                run, safe = (run_bench(one.with_values(at), 40.0, seed) for one in (free, guarded))
                hot = [one["temperature"].max() - 273.15 for one in (run, safe)]
                rows.append((find_delay(run, onset), find_visible(run, alone, onset), *hot))
        seen, possible, hot, safe = np.array(rows).T
        both = [f"{np.median(one):.2f}, {one.max():.2f} s" for one in (seen, possible)]
        print(
            f"{label:14} {both[0]:>16} {both[1]:>16} {np.mean(seen <= 2.0):>10.0%} {hot.max():8.0f} {safe.max():8.0f}"
        )
    hours = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    for seed in range(600, 600 + hours):
        run = run_bench(guarded, 3600.0, seed)
        print(f"an hour: least confidence {run['estimated.confidence'].min():.2f}, alarm {run['alarm'].max():.0f}")


if __name__ == "__main__":
    main()
