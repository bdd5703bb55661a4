"""The part `laws` of the benchmark page: one law along a path, beside two other programs.

What: a thermal loop at constant stress with the law of Lagoudas and the alloy of the peers, with
linear hardening. simcoon begins hot and cools, SMA_REACT begins cold and heats, because each can
only do that; ours is run both ways, so that each is judged by the same path.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from benchmarks import law_paths
from benchmarks.harness import Candidate, measure
from benchmarks.law_paths import LANES, Case
from benchmarks.page_parts import FLOATS, Choice, part
from benchmarks.peers import simcoon_path, sma_react_path
from benchmarks.peers.simcoon_path import ALLOY, Alloy
from benchmarks.report import Table
from benchmarks.sections_laws import apart
from martensite.physics.laws.lagoudas import Lagoudas

BASE, STEPS = "martensite, C", 1000
LINEAR = ALLOY._replace(exponent=1.0)
HOT, COLD = (law_paths.STRESS, 423.15), (law_paths.STRESS, 293.15)  # [Pa], [K]


def law_of(alloy: Alloy) -> Lagoudas:
    """The law of the library with the numbers of an alloy."""
    a = alloy
    return Lagoudas(
        E_A=a.E_A,
        E_M=a.E_M,
        A_s=a.A_s,
        A_f=a.A_f,
        M_s=a.M_s,
        M_f=a.M_f,
        C_A=a.C_A,
        C_M=a.C_M,
        sigma_cal=a.calibration,
        H_min=a.H_min,
        H_sat=a.H_max,
        H_k=a.k,
        **dict.fromkeys(("n_1", "n_2", "n_3", "n_4"), a.exponent),
    )


def law_batches(given: Case) -> list[Candidate]:
    """A chunk of lanes in C."""
    compiled, values = law_paths.lanes_of(given, LANES)
    exact = law_paths.judged(given, compiled, values[:, 0])

    def error(chunks: Any) -> float:
        return apart(chunks[0][:, 0], exact)

    run = law_paths.by_simd(given, compiled, values)
    return [Candidate("martensite, C lanes", run, error, LANES, f"batch of {LANES}")]


def peers(exact: dict[str, Any]) -> list[Candidate]:
    """The other programs that are there, each judged by the path that it runs."""

    def made(name: str, setting: str, path: Any, way: str) -> Candidate:
        def error(loop: simcoon_path.Loop) -> float:
            return apart(loop.strain, exact[way])

        run = partial(path, STEPS, LINEAR, repeats=1)
        return Candidate(name, run, error, 1, setting, clock=lambda loop: loop.seconds)

    found: list[Candidate] = []
    if simcoon_path.available():
        path = simcoon_path.thermal_path
        found.append(made("simcoon (SMADI)", f"{STEPS} increments", path, "cooled"))
    if sma_react_path.checkout():
        path = sma_react_path.thermal_path
        found.append(made("SMA_REACT (model core)", "implicit", path, "heated"))
    return found


@part
def laws(choice: Choice) -> list[Table]:
    """A thermal loop of the Lagoudas law, beside two other programs."""
    law = law_of(LINEAR)
    ways = {"cooled": Case(law, STEPS // 2, HOT, COLD), "heated": Case(law, STEPS // 2, COLD, HOT)}
    exact = {way: np.array(law_paths.single(given, "floats")()) for way, given in ways.items()}
    cooled = ways["cooled"]
    runs = [
        Candidate(name, law_paths.single(cooled, kind), lambda found: apart(found, exact["cooled"]))
        for name, kind in {BASE: "c", FLOATS: "floats"}.items()
    ]
    runs += [*law_batches(cooled), *peers(exact)]
    rows = [
        {"engine": t.name, "setting": t.setting, "err": t.err, "spread": t.spread, "ratio": t.ratio}
        for t in measure(runs, choice.repeats, BASE)
    ]
    return [Table(f"Thermal loop of {STEPS} steps", rows)]
