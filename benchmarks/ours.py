"""martensite on problem A: the same system, on every runtime.

What: the wire, drive and spring of `problem_a` as a `System`, marched over exactly the steps of
`inputs.aligned`. `c` and `simd` are C99 printed from the same traced kernels, compiled with all
optimisation, for one run or 256 lanes at a time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from benchmarks.engines import Engine
from benchmarks.inputs import Drive, aligned, level
from benchmarks.problem_a import THETA, Wire, one_set
from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire as Element
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.base.parameters import part
from martensite.kernels.c99_lanes import BLOCK
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import VoltageSource
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import PolynomialCooling
from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import Moments, Segment, Tone
from martensite.simulate.compiled import CompiledMarch, compile_march, feed_step
from martensite.simulate.grid import TimeGrid
from martensite.simulate.march import march_floats

LANES = 256
ZERO = 273.15
PATHS = {
    "h0": "environment.cooling.h0",
    **{n: f"element.law.{n}" for n in ("A_s", "A_f", "M_s", "M_f", "C_A", "C_M", "eps_L")},
    "latent": "element.latent_heat",
    "c": "element.heat_capacity",
}


def system(p: Wire) -> System:
    """Problem A at one parameter set."""
    law = LiangRogers(
        E_A=p.E_A,
        E_M=p.E_M,
        eps_L=p.eps_L,
        C_A=p.C_A,
        C_M=p.C_M,
        Theta=p.Theta,
        A_s=p.A_s + ZERO,
        A_f=p.A_f + ZERO,
        M_s=p.M_s + ZERO,
        M_f=p.M_f + ZERO,
        T_ref=p.T_a + ZERO,
        modulus="mixture",
    )
    warm = (1 + p.kappa) * p.resistance
    wire = Element(
        diameter=p.diameter,
        length=p.length,
        density=p.density,
        heat_capacity=p.c,
        latent_heat=p.latent,
        law=law,
        resistance=PerLengthResistance(r_A=p.resistance, r_M=warm),
    )
    cooling = PolynomialCooling(h0=p.h0, h1=p.h1, reference=p.T_a + ZERO)
    return System(
        element=wire,
        environment=Environment(temperature=p.T_a + ZERO, cooling=cooling),
        source=VoltageSource(),
        mechanism=BiasSpring(stiffness=p.rate, preload=p.preload),
    )


def grid(drive: Drive, longest: float) -> TimeGrid:
    """The steps of `aligned` as a grid of voltages."""
    rows = aligned(drive, longest)
    volts = [[math.sqrt(U) for U, _ in row] for row in rows]
    return TimeGrid(
        times=[k / 10 for k in range(len(rows) + 1)],
        sampled=[(volts[0][0],), *((row[-1],) for row in volts)],
        counts=[len(row) for row in rows],
        lengths=[dt for row in rows for _, dt in row],
        drives=[feed_step(Moments.constant(v)) for row in volts for v in row],
    )


def traced(p: Wire) -> tuple[CompiledMarch, list[float]]:
    """The traced system and its parameter values."""
    whole = system(p)
    compiled = compile_march(whole)
    return compiled, compiled.values(whole)


def position(compiled: CompiledMarch) -> int:
    """Column of the displacement."""
    return compiled.outputs.index("position")


def floats(p: Wire, drive: Drive, dt: float) -> Callable[[], Any]:
    """One run on plain floats."""
    (compiled, values), steps = traced(p), grid(drive, dt)
    functions, column = compiled.program.bind_floats(*values), position(compiled)
    return lambda: [1e3 * row[column] for row in march_floats(functions, compiled.size, steps).rows]


def latency(p: Wire, dt: float) -> tuple[Any, Callable[[Any, float], Any]]:
    """One step at a time on plain floats, as a control loop would call it."""
    compiled, values = traced(p)
    functions, size = compiled.program.bind_floats(*values), compiled.size
    step = functions["step"]

    def advance(state: Any, U: float) -> Any:
        return step(*state, *feed_step(Moments.constant(math.sqrt(U))), dt)[:size]

    return functions["init"](0.0), advance


def varied(sets: Wire) -> tuple[CompiledMarch, list[Any]]:
    """The traced system with arrays where the sets have arrays."""
    first = sets._replace(**{name: float(getattr(sets, name)[0]) for name in THETA})
    compiled, values = traced(first)
    for name, path in PATHS.items():
        array = getattr(sets, name)
        values[compiled.paths.index(path)] = array + (ZERO if name in THETA[1:5] else 0.0)
    return compiled, values


def chunked(values: list[Any], lanes: int) -> list[list[Any]]:
    """Values in chunks of exactly `lanes` variants (the last padded by its last variant)."""
    import numpy as np

    size = max(np.size(v) for v in values)
    lanes = min(lanes, size)

    def cut(v: Any, first: int) -> Any:
        if np.ndim(v) == 0:
            return v
        part = v[first : first + lanes]
        return np.pad(part, (0, lanes - part.size), mode="edge")

    return [[cut(v, first) for v in values] for first in range(0, size, lanes)]


def native(lanes: int) -> Callable[..., Callable[[], Any]]:
    """The traced C: one run, or all sets `lanes` at a time."""

    def prepare(p: Wire, drive: Drive, dt: float) -> Callable[[], Any]:
        import numpy as np

        from martensite.simulate.native import march_lanes

        (compiled, values), steps = traced(p) if lanes == 1 else varied(p), grid(drive, dt)
        pieces, column = chunked(values, lanes), position(compiled)
        size = np.size(p.h0)
        width = min(lanes, size)

        def go() -> Any:
            rows = [march_lanes(compiled, v, steps, width, [column])[0][:, 0].T for v in pieces]
            return 1e3 * (rows[0][0] if lanes == 1 else np.concatenate(rows)[:size])

        return go

    return prepare


def gradient(p: Wire, drive: Drive, dt: float) -> Callable[[], Any]:
    """dJ/dq by forward derivatives beside the run, in C."""
    import numpy as np

    from benchmarks.problem_a import scaled, target_factors
    from martensite.simulate.native_slopes import march_slopes

    (compiled, values), steps = traced(p), grid(drive, dt)
    wanted = native(1)(scaled(p, target_factors()), drive, dt)()
    seeds = np.zeros((len(values), len(THETA)))
    for k, name in enumerate(THETA):
        seeds[compiled.paths.index(PATHS[name]), k] = getattr(p, name)

    def go() -> Any:
        found = march_slopes(compiled, values, seeds, steps, [position(compiled)])
        gap = 1e3 * found.rows[:, 0] - wanted
        return 2e3 * np.mean(gap[:, None] * found.slopes[:, 0], axis=0) / np.ptp(wanted) ** 2

    return go


class Volts(AbstractWaveform):
    """A drive of the problem as a waveform [V]: its tones, or its levels."""

    drive: Drive = part("what is played")

    def value(self, time: float) -> float:
        """The voltage at a time [s]."""
        return math.sqrt(level(self.drive, time))

    def segments(self, begin: float) -> Iterator[Segment]:
        """The mean of the tones, or every level."""
        if not self.drive.edges:
            yield Segment(0.0, 2.8 * 0.66)
            return
        for edge, square in zip(self.drive.edges, self.drive.levels, strict=True):
            yield Segment(edge, math.sqrt(square))

    def tones(self) -> tuple[Tone, ...]:
        """Two, if there are no levels."""
        tones = (Tone(-2.8 * 0.34, 0.2 * math.pi), Tone(-2.8 * 0.2, 0.046 * math.pi))
        return () if self.drive.edges else tones


def march(lanes: int) -> Callable[..., Callable[[], Any]]:
    """The march with an error control in C: one run, or all sets, `lanes` side by side."""

    def prepare(p: Wire, drive: Drive, tolerance: float) -> Callable[[], Any]:
        import numpy as np

        from martensite.simulate.envelope import envelope_of
        from martensite.simulate.marching import MarchPlan
        from martensite.simulate.marching_native import NativeMarch, Runs, march_runs
        from martensite.simulate.restarts import SampleTimes

        size = int(np.size(p.h0))
        compiled, values = traced(p) if lanes == 1 else varied(p)
        one = p._replace(**{name: float(np.ravel(getattr(p, name))[0]) for name in THETA})
        times = SampleTimes(k / 10 for k in range(round(10 * drive.duration) + 1))
        plan = MarchPlan(
            compiled, [Volts(drive=drive)], times, tolerance, 0.02, envelope_of(system(one)), recorded=False
        )
        runs = Runs(plan, values, size, (position(compiled),), lanes)
        if lanes > 1:
            return lambda: 1e3 * march_runs(runs).outputs[:, :, 0]
        prepared = NativeMarch(runs)

        def again() -> Any:
            prepared.set_runs(runs)
            return 1e3 * prepared.go().outputs[0, :, 0]

        return again

    return prepare


def call(p: Wire, drive: Drive, tolerance: float) -> Callable[[], Any]:
    """What a user calls: `simulate` in C, all outputs, with its error bound."""
    from martensite.simulate.api import simulate

    whole, waveform, samples = system(p), Volts(drive=drive), round(10 * drive.duration) + 1
    return lambda: (
        1e3 * simulate(whole, waveform, drive.duration, tolerance=tolerance, samples=samples, runtime="c")["position"]
    )


def call_batch(sets: Wire, drive: Drive, tolerance: float) -> Callable[[], Any]:
    """What a user calls: `simulate_batch` in C on one thread, positions with their error bounds."""
    from martensite.simulate.batch import simulate_batch

    first = one_set(sets, 0)
    over = {path: getattr(sets, name) + (ZERO if name in THETA[1:5] else 0.0) for name, path in PATHS.items()}
    whole, waveform, samples = system(first), Volts(drive=drive), round(10 * drive.duration) + 1
    options: dict[str, Any] = {"tolerance": tolerance, "samples": samples, "runtime": "c"}
    return lambda: 1e3 * simulate_batch(whole, waveform, drive.duration, over, **options)["position"]


TOLERANCES = {f"tol {n}": float(n) for n in ("1e-3", "3e-4", "1e-4", "3e-5", "1e-5", "3e-6", "1e-6")}
ASKED = {"tol 3e-3": 3e-3} | TOLERANCES  # a call is more exact than its tolerance; at 1e-2 a near miss is undecided
STEPS = {f"dt {ms:g} ms": ms * 1e-3 for ms in (50, 20, 10, 5)}
USUAL = "dt 20 ms"

ENGINES = (
    Engine("ours", "P", STEPS, USUAL, single=floats, step=latency),
    Engine("ours-c", "P", STEPS, USUAL, single=native(1), gradient=gradient),
    Engine("ours-call", "P", ASKED, "tol 1e-4", single=call, batch=call_batch),
    Engine("ours-march", "P", TOLERANCES, "tol 1e-4", single=march(1), batch=march(BLOCK)),
    Engine("ours-simd", "P", STEPS, USUAL, batch=native(LANES)),
)
