"""How true are fits of logs alone? Random rigs, fitted without a scenario and compared with their truth.

    python -m benchmarks.true_fits --rigs 40 [--seed 7000] [--numbers FILE.json] [--page]

Each rig is fitted by `model_logs`, as `martensite fit LOG...` does. The numbers are

    fit        of a record that the model never saw: another cadence, a partial loop, another temperature
    verdict    right if the model is said to predict exactly when it explains 75 % of that record, and errs less
               than 0.8 of the first-order lag (driven) or of the mean
    intervals  95 % intervals of A_s, A_f, M_s, M_f (and C of tensile and recovery tests) that contain the truth

Results are added to the numbers file after every rig, so that an interrupted run continues. `--page` writes the table
of `docs/explanation/how-true-is-it.md` from them.
"""

from __future__ import annotations

import json
import math
import time
from argparse import ArgumentParser
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.driven_rigs import draw_rig
from benchmarks.given_rigs import ZERO, CosineWire, draw_given_rig, draw_wire
from martensite.characterise.calorimetry import fit_calorimetry
from martensite.fit.drive_lag import fit_drive_lag
from martensite.fit.log_models import LogModel, model_logs
from martensite.search.rivals import BETTER, EXPLAINED
from martensite.signals.records import Record

ROOT = Path(__file__).resolve().parent.parent
NUMBERS = ROOT / "docs/explanation/how-true-is-it.json"
PAGE = NUMBERS.with_suffix(".md")
KINDS = ("dsc", "tensile", "bath", "recovery", "driven")
TITLES = {
    "dsc": "DSC, three rates",
    "tensile": "tensile tests at three temperatures",
    "bath": "weight or spring in a bath",
    "recovery": "constrained recovery",
    "driven": "wire driven against weight, spring or grips",
    "outside": "the same, outside of the models",
}
MARK = "<!-- numbers -->"
SQRT2 = math.sqrt(2.0)


def judge_given(kind: str, seed: int) -> dict[str, Any]:
    """Return the numbers of a rig at given temperatures or strains."""
    rig = draw_given_rig(kind, seed)
    model = model_logs(rig.records, overrides=dict(rig.settings))
    predicted = model.predict_record(rig.unseen)[rig.column]
    return compare(model, predicted, rig.unseen[rig.column], math.inf) | count_intervals(model, rig.wire, kind)


def judge_driven(_: str, seed: int) -> dict[str, Any]:
    """Return the numbers of a driven rig; every fifth rig does not follow the fitted models."""
    rig = draw_rig(seed)
    model = model_logs(rig.records)
    (predicted,) = model.predict_record(rig.unseen).values()
    lag = fit_drive_lag(rig.records, rig.drive, rig.column, refined=2).predict(rig.unseen, rig.drive)
    naive = float(np.sqrt(np.mean((lag - np.asarray(rig.unseen[rig.column])) ** 2)))
    return {"outside": rig.outside} | compare(model, predicted, rig.unseen[rig.column], naive)


def compare(model: LogModel, predicted: Any, measured: Any, naive: float) -> dict[str, Any]:
    """Return the fit of an unseen record, and whether the verdict about it is right."""
    y = np.asarray(measured, float)
    error, spread = float(np.sqrt(np.mean((np.asarray(predicted) - y) ** 2))), float(np.std(y))
    truth = 1.0 - error / spread >= EXPLAINED and error < BETTER * min(naive, spread)
    return {"fit": 100.0 * (1.0 - error / spread), "predicts": model.predicts, "right": model.predicts == truth}


def count_intervals(model: LogModel, wire: CosineWire, kind: str) -> dict[str, Any]:
    """Return the number of intervals that contain the truth, and of all."""
    found = [one for one in model.temperatures if one.stress == 0.0 and not one.assumed]
    ends = [(one.value - one.half_width, getattr(wire, one.name) + ZERO, one.value + one.half_width) for one in found]
    if kind in ("tensile", "recovery"):
        known = set(model.fit.problem.names)
        slopes = [model.fit.uncertainty.widen_interval(name) for name in ("C_A", "C_M") if name in known]
        ends += [(low, wire.C, high) for low, high in slopes]
    return {"inside": sum(low <= true <= high for low, true, high in ends), "intervals": len(ends)}


def judge_dsc(_: str, seed: int) -> dict[str, Any]:
    """Return the numbers of a calorimeter's record at 5, 10 and 20 K/min; Gaussian peaks, whose tangents are known."""
    chance = np.random.default_rng(seed)
    wire = draw_wire(chance)
    area, lag, c, zero = chance.uniform(8e3, 24e3), chance.uniform(2.0, 15.0), 460.0, chance.uniform(-20.0, 20.0)
    peaks = {1.0: (0.5 * (wire.A_s + wire.A_f), (wire.A_f - wire.A_s) / SQRT2 / 2.0)}
    peaks[-1.0] = (0.5 * (wire.M_s + wire.M_f), (wire.M_s - wire.M_f) / SQRT2 / 2.0)
    parts: dict[str, list[Any]] = {"time": [], "temperature": [], "heat_flow": []}
    clock = 0.0
    for rate in (5.0, 10.0, 20.0):
        for way, (at, wide) in peaks.items():
            speed, T = way * rate / 60.0, np.linspace(-30.0, 150.0, 1500)[:: int(way)]
            shape = area / wide / math.sqrt(math.pi) * np.exp(-(((T - at - lag * speed) / wide) ** 2))
            heat = (c + shape) * speed + zero
            parts["time"].append(clock + np.abs(T - T[0]) / abs(speed))
            parts["temperature"].append(T + ZERO + 0.02 * chance.standard_normal(len(T)))
            parts["heat_flow"].append(heat + 0.3 * chance.standard_normal(len(T)))
            clock = parts["time"][-1][-1] + 1.0
    columns = {name: np.concatenate(one).tolist() for name, one in parts.items()}
    found = fit_calorimetry(Record("dsc", columns, {"time": "s", "temperature": "K", "heat_flow": "W/kg"}))
    ends = [(*one.interval(), getattr(wire, name) + ZERO) for name, one in found.values.items()]
    errors = [abs(one.value - getattr(wire, name) - ZERO) for name, one in found.values.items()]
    heat = found.latent_heat.value if found.latent_heat else math.nan
    return {
        "error": max(errors),
        "heat": abs(heat / area - 1.0),
        "inside": sum(low <= true <= high for low, high, true in ends),
        "intervals": len(ends),
    }


def run(kinds: Iterable[str], rigs: int, seed: int, numbers: Path, every: int = 1) -> list[dict[str, Any]]:
    """Judge rigs of some kinds in turn, with seeds that are `every` apart, and return all results."""
    done: list[dict[str, Any]] = json.loads(numbers.read_text("utf-8")) if numbers.exists() else []
    names = list(kinds)
    known = {(one["kind"], one["seed"]) for one in done}
    for k in range(rigs):
        kind, own = names[k % len(names)], seed + every * (k // len(names))
        if (kind, own) in known:
            continue
        begin = time.process_time()
        judge = {"dsc": judge_dsc, "driven": judge_driven}.get(kind, judge_given)
        found = {"kind": kind, "seed": own, **judge(kind, own), "cpu": time.process_time() - begin}
        done.append(found)
        numbers.write_text(json.dumps(done, indent=0, default=float) + "\n", encoding="utf-8")
        print({key: round(x, 2) if isinstance(x, float) else x for key, x in found.items()}, flush=True)
    return done


def write_table(done: list[dict[str, Any]]) -> str:
    """Return the table of the page."""
    lines = [
        "| test | rigs | median fit of an unseen record | verdict right | 95 % intervals that hold | CPU, median |"
    ]
    lines.append("| --- | ---: | ---: | ---: | ---: | ---: |")
    for kind in (*KINDS, "outside", "all"):
        own = [one for one in done if kind in (_find_row(one), "all")]
        if own:
            lines.append(_write_row(TITLES.get(kind, kind), own))
    dsc = [one for one in done if one["kind"] == "dsc"]
    if dsc:
        worst, heat = max(one["error"] for one in dsc), 100.0 * max(one["heat"] for one in dsc)
        lines += [
            "",
            f"In DSC, the largest error of a temperature is {worst:.1f} K, and of the latent heat {heat:.1f} %.",
        ]
    return "\n".join(lines)


def _find_row(one: dict[str, Any]) -> str:
    """Return the kind of a rig, or `outside` for a driven rig that no fitted model describes."""
    return "outside" if one.get("outside") else str(one["kind"])


def _write_row(title: str, own: list[dict[str, Any]]) -> str:
    fits = [one["fit"] for one in own if "fit" in one]
    right = [one["right"] for one in own if "right" in one]
    inside, count = (sum(one.get(key, 0) for one in own) for key in ("inside", "intervals"))
    cells = [
        f"{np.median(fits):.1f} %" if fits else "–",
        f"{sum(right)} of {len(right)}" if right else "–",
        f"{inside} of {count} ({100.0 * inside / count:.0f} %)" if count else "–",
        f"{np.median([one['cpu'] for one in own]):.1f} s",
    ]
    return f"| {title} | {len(own)} | {' | '.join(cells)} |"


def write_page(done: list[dict[str, Any]]) -> None:
    """Replace the table of the page."""
    head, _, rest = PAGE.read_text("utf-8").partition(MARK)
    _, _, tail = rest.partition(MARK)
    PAGE.write_text(f"{head}{MARK}\n\n{write_table(done)}\n\n{MARK}{tail}", encoding="utf-8")


def main() -> None:
    """Run the benchmark from the command line."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=7000)
    parser.add_argument(
        "--every", type=int, default=1, help="distance of the seeds; 5 from a seed that ends with 4 or 9"
    )
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--numbers", type=Path, default=NUMBERS)
    parser.add_argument("--page", action="store_true")
    given = parser.parse_args()
    done = run(given.kinds, given.rigs, given.seed, given.numbers, given.every)
    print(write_table(done))
    if given.page:
        write_page(done)


if __name__ == "__main__":
    main()
