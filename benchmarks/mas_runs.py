"""martensite on problem B: one system, marched on every runtime, single or for many wires.

What: the wire of `problem_b` with the rate law `mas`, or with its rate-independent limit
`mas-hybrid`, over 201 samples and steps of at most the given length, or those of an error control.
Single runs and the C lanes are timed without the preparation of the grid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.problem_b import DURATION, OUTPUT_INTERVAL, Wire, system, waveform
from martensite.base.status import Status
from martensite.kernels.c99_lanes import BLOCK
from martensite.simulate.api import simulate
from martensite.simulate.batch import simulate_batch
from martensite.simulate.compiled import compile_march
from martensite.simulate.envelope import envelope_of
from martensite.simulate.grid import TimeGrid, build_grid
from martensite.simulate.march import classify_step, march_floats
from martensite.simulate.marching import MarchPlan
from martensite.simulate.marching_native import NativeMarch, Runs, march_runs
from martensite.simulate.native import march_lanes

LANES = 256
SAMPLES = round(DURATION / OUTPUT_INTERVAL) + 1
COLUMNS = ("position", "stress", "strain")
SHARES = {
    "h": 0.10,
    "eps_T": 0.10,
    "latent": 0.10,
    "c": 0.10,
    "E_M": 0.10,
    "sigma_L": 0.05,
    "dsigma_dT": 0.05,
    "Delta_sigma": 0.10,
    "layer_volume": 0.20,
    "layer_time": 0.30,
}
NAMES = {"latent": "latent_heat", "c": "heat_capacity"}


class Problem(NamedTuple):
    """Which wire, law and form of the rates."""

    wire: Wire
    law: str = "mas"
    form: str = "edge"

    def system(self) -> Any:
        """Posed to the library."""
        options = {"rates": self.form} if self.law == "mas" else {}
        return system(self.wire, self.law, **options)


def parameter_sets(p: Wire, count: int) -> list[Wire]:
    """`count` wires around a nominal one, which is the first."""
    rng, drawn = np.random.default_rng(0), {}
    for name, share in SHARES.items():
        factors = 1.0 + share * (2.0 * rng.random(count) - 1.0)
        factors[0] = 1.0
        drawn[name] = (getattr(p, name) * factors).tolist()
    return [p._replace(**dict(zip(drawn, row, strict=True))) for row in zip(*drawn.values(), strict=True)]


def grid(step: float) -> TimeGrid:
    """Samples, and steps of at most `step` [s]."""
    return build_grid([waveform()], DURATION, SAMPLES, step, [False])


def scaled(columns: Any, failed: bool) -> Any:
    """x [mm], stress [Pa], strain [1], one row each; not numbers where a step failed."""
    found = np.array(columns, float)
    found[0] *= 1e3
    return np.full_like(found, np.nan) if failed else found


def judged(march: Callable[[], tuple[Any, Status]]) -> Callable[[], Any]:
    """The columns of a march, not numbers where it failed."""

    def run() -> Any:
        found, status = march()
        return scaled(found, status.failed)

    return run


def prepared(problem: Problem, step: float) -> tuple[Any, TimeGrid, list[int]]:
    """The system, its grid, and the places of the columns that are judged."""
    whole = problem.system()
    outputs = compile_march(whole).outputs
    return whole, grid(step), [outputs.index(name) for name in COLUMNS]


def floats(problem: Problem, step: float) -> Callable[[], Any]:
    """One run on plain floats."""
    whole, steps, places = prepared(problem, step)

    def march() -> tuple[Any, Status]:
        compiled = compile_march(whole)
        functions = compiled.program.bind_floats(*compiled.values(whole))
        track = march_floats(functions, compiled.size, steps)
        return [[row[i] for row in track.rows] for i in places], track.status

    return judged(march)


def native(problem: Problem, step: float) -> Callable[[], Any]:
    """One run in C."""
    whole, steps, places = prepared(problem, step)

    def march() -> tuple[Any, Status]:
        compiled = compile_march(whole)
        rows, worst = march_lanes(compiled, compiled.values(whole), steps, 1, places)
        return rows[:, :, 0].T, classify_step(*worst[:2, 0].tolist())

    return judged(march)


def plan_of(whole: Any, tolerance: float) -> MarchPlan:
    """A march with error control."""
    times = [OUTPUT_INTERVAL * k for k in range(SAMPLES)]
    limits = envelope_of(whole)
    return MarchPlan(compile_march(whole), [waveform()], times, tolerance, OUTPUT_INTERVAL, limits, recorded=False)


def adaptive(problem: Problem, tolerance: float) -> Callable[[], Any]:
    """One run in C with an error control in every step."""
    whole = problem.system()
    plan = plan_of(whole, tolerance)
    places = tuple(plan.compiled.outputs.index(name) for name in COLUMNS)
    runs = Runs(plan, plan.compiled.values(whole), 1, places, 1)
    prepared = NativeMarch(runs)

    def march() -> tuple[Any, Status]:
        prepared.set_runs(runs)
        found = prepared.go()
        return found.outputs[0].T, Status(int(found.numbers[0, 0]))

    return judged(march)


def call(problem: Problem, tolerance: float) -> Callable[[], Any]:
    """What a user calls: `simulate` in C, all outputs, with its error bound."""
    whole, drive = problem.system(), waveform()
    options: dict[str, Any] = {"tolerance": tolerance, "samples": SAMPLES, "runtime": "c"}

    def run() -> Any:
        result = simulate(whole, drive, DURATION, **options)
        return scaled([result[name] for name in COLUMNS], failed=False)  # what is missing is NaN

    return run


SINGLE = {"ours, floats": floats, "ours, C": native, "ours, march": adaptive, "ours, call": call}


# ---------------------------------------------------------------- batches


def simd_batch(problem: Problem, sets: list[Wire], step: float) -> Callable[[], Any]:
    """x [mm] of all sets in C, `LANES` at a time."""
    whole, steps = problem.system(), grid(step)
    compiled = compile_march(whole)
    width, place = min(LANES, len(sets)), compiled.outputs.index("position")
    nominal = compiled.values(whole)
    varied = {
        compiled.paths.index(whole.resolve(NAMES.get(name, name))): [getattr(p, name) for p in sets] for name in SHARES
    }
    chunks = [
        [np.array(varied[i][k : k + width]) if i in varied else v for i, v in enumerate(nominal)]
        for k in range(0, len(sets), width)
    ]

    def run() -> Any:
        rows = []
        for chunk in chunks:
            found, worst = march_lanes(compiled, chunk, steps, width, [place])
            failed = np.array([classify_step(*pair[:2]).failed for pair in worst.T.tolist()])
            rows.append(np.where(failed[:, None], np.nan, 1e3 * found[:, 0].T))
        return np.concatenate(rows)

    return run


def adaptive_batch(problem: Problem, sets: list[Wire], tolerance: float) -> Callable[[], Any]:
    """x [mm] of all sets in C with an error control, each run on steps of its own."""
    whole = problem.system()
    plan = plan_of(whole, tolerance)
    values: list[Any] = list(plan.compiled.values(whole))
    for name in SHARES:
        path = whole.resolve(NAMES.get(name, name))
        values[plan.compiled.paths.index(path)] = [getattr(p, name) for p in sets]
    place = plan.compiled.outputs.index("position")
    runs = Runs(plan, values, len(sets), (place,), BLOCK)

    def run() -> Any:
        found = march_runs(runs)
        failed = found.numbers[:, 0] >= Status.UNSOLVED
        return np.where(failed[:, None], np.nan, 1e3 * found.outputs[:, :, 0])

    return run


def call_batch(problem: Problem, sets: list[Wire], tolerance: float) -> Callable[[], Any]:
    """What a user calls: `simulate_batch` in C on one thread, x [mm] with error bounds."""
    whole, drive = problem.system(), waveform()
    over = {whole.resolve(NAMES.get(name, name)): [getattr(p, name) for p in sets] for name in SHARES}
    options: dict[str, Any] = {"tolerance": tolerance, "samples": SAMPLES, "runtime": "c"}
    return lambda: 1e3 * simulate_batch(whole, drive, DURATION, over, **options)["position"]


BATCH = {"ours, SIMD C": simd_batch, "ours, march": adaptive_batch, "ours, call": call_batch}


class Setting(NamedTuple):
    """How exact an engine is asked to be: a step, or a tolerance."""

    value: float
    label: str


def settings_of(name: str, numbers: Sequence[float]) -> list[Setting]:
    """Of an engine, from tolerances or steps [ms]."""
    if name in ("ours, march", "ours, call"):
        return [Setting(x, f"tol {x:.0e}") for x in numbers]
    return [Setting(1e-3 * x, f"dt {x:g} ms") for x in numbers]
