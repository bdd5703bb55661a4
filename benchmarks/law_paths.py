"""Laws along material paths: one run as a user makes it, or many lanes at once.

What: every registered law with the numbers of the first shipped material that has all it needs,
driven through a superelastic loop (stress up and down) or a thermal loop (cooling and heating at
200 MPa) in equal steps. A single run is `material_point` with its result. In a batch every
parameter of the law differs from lane to lane, so that nothing is constant to a compiler, and the
strain after every step is kept, by C printed from the trace, `LANES` lanes at a time.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from martensite.base.parameters import REQUIRED
from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import BLOCK, lanes_source
from martensite.kernels.compiler import load_library
from martensite.physics.laws.base import LAWS, AbstractLaw
from martensite.physics.materials.base import load_material
from martensite.simulate.compiled_law import ROW, CompiledLaw, compile_law
from martensite.simulate.point import PathLeg, material_point

LANES = 256
SPREAD = 0.004  # of every parameter; more would let the strips of some lanes change places
SECONDS = 100.0  # [s] of a path, for laws with rates
STRESS = 200e6  # [Pa] of the thermal loop


class Ends(NamedTuple):
    """Where the loops of a material end, so that it transforms wholly and back."""

    temperature: float  # [K] of the superelastic loop
    top: float  # [Pa]
    hot: float  # [K] of the thermal loop
    cold: float  # [K]


MATERIALS = {
    "niti-brinson-1993": Ends(325.0, 600e6, 380.0, 270.0),
    "niti-lagoudas": Ends(345.0, 800e6, 420.0, 270.0),
    "finger-mas": Ends(380.0, 600e6, 430.0, 300.0),
    "niti-r-phase": Ends(380.0, 800e6, 430.0, 260.0),
}


class Case(NamedTuple):
    """A law and one loop, in 2 `half` equal steps."""

    law: AbstractLaw
    half: int
    start: tuple[float, float]  # [Pa], [K]
    turn: tuple[float, float]

    @property
    def points(self) -> Any:
        """Stress [Pa] and temperature [K] at the end of every step, (steps, 2)."""
        start, turn = np.array(self.start), np.array(self.turn)
        away = np.arange(1, self.half + 1)[:, None] / self.half
        return np.concatenate([start + away * (turn - start), turn + away * (start - turn)])

    @property
    def dt(self) -> float:
        """Length of a step [s]."""
        return 0.5 * SECONDS / self.half


def example(name: str) -> tuple[AbstractLaw, str]:
    """A law with the numbers of a shipped material, and that material."""
    declared = {k: d for k, d in LAWS[name].declarations.items() if d.kind == "parameter"}
    needed = {k for k, d in declared.items() if d.default is REQUIRED}
    for material in MATERIALS:
        numbers = {k: n.value for k, n in load_material(material).values.items() if k in declared}
        if needed <= numbers.keys():
            return LAWS[name](**numbers), material
    raise SystemExit(f"No material of {', '.join(MATERIALS)} has all that `{name}` needs.")


def case(name: str, loop: str, steps: int) -> Case:
    """The `superelastic` or `thermal` loop of a law."""
    law, material = example(name)
    ends = MATERIALS[material]
    if loop == "superelastic":
        corners = (0.0, ends.temperature), (ends.top, ends.temperature)
    else:
        corners = (STRESS, ends.hot), (STRESS, ends.cold)
    return Case(law, steps // 2, *corners)


def single(given: Case, runtime: str) -> Callable[[], Any]:
    """One run; returns the strain after every step."""
    legs = [
        PathLeg(stress=stress, temperature=temperature, duration=0.5 * SECONDS)
        for stress, temperature in (given.turn, given.start)
    ]

    def run() -> Any:
        found = material_point(given.law, legs, start=given.start, steps=given.half, tolerance=None, runtime=runtime)
        return found.strain[1:]

    return run


# ---------------------------------------------------------------- batches


def lanes_of(given: Case, count: int) -> tuple[CompiledLaw, Any]:
    """The traced law, and its parameters in `count` lanes (parameters, lanes), the first as is."""
    compiled = compile_law(given.law)
    values = np.array(compiled.values(given.law))[:, None]
    drawn = np.random.default_rng(0).uniform(-SPREAD, SPREAD, (len(values), count))
    drawn[:, 0] = 0.0
    return compiled, values * (1.0 + drawn)


def judged(given: Case, compiled: CompiledLaw, lane: Any) -> list[float]:
    """Strain after every step of one lane, on floats."""
    functions = compiled.program.bind_floats(*lane.tolist())
    state, found = functions["init"](0.0, 0.0, *given.start)[: compiled.size], []
    for stress, temperature in given.points.tolist():
        *state, _, _, strain, _, _ = functions["stress_step"](*state, stress, temperature, given.dt)
        found.append(strain)
    return found


def chunks_of(values: Any) -> list[Any]:
    """Lanes in pieces of `LANES`; the last may be shorter only if it is the only one."""
    count = values.shape[1]
    if count > LANES and count % LANES:
        raise SystemExit(f"A batch must be at most or a multiple of {LANES}, but is {count}.")
    return [np.ascontiguousarray(values[:, k : k + LANES]) for k in range(0, count, LANES)]


_RIDE = """
void ride(long steps, const double *restrict p, const double *restrict start,
          const double *restrict path, double dt, double *restrict rows) {{
    enum {{ n = {lanes} }};
    static _Thread_local double c[{constants} * n], x[{inputs} * n], y[{results} * n];
    k_prepare(n, p, c);
    for (long l = 0; l < n; l++) {{
        x[l] = x[n + l] = 0.0; x[2 * n + l] = start[0]; x[3 * n + l] = start[1];
    }}
    k_init(n, c, x, y);
    for (long k = 0; k < steps; k++, path += 2, rows += n) {{
        memcpy(x, y, sizeof(double) * {size} * n);
        for (long l = 0; l < n; l++) {{
            x[{size} * n + l] = path[0]; x[({size} + 1) * n + l] = path[1];
            x[({size} + 2) * n + l] = dt;
        }}
        k_stress_step(n, c, x, y);
        memcpy(rows, y + {size} * n, sizeof(double) * n);
    }}
}}
"""


@cache
def library(compiled: CompiledLaw, lanes: int) -> Any:
    """The march in C for a fixed number of lanes; of the row it keeps the strain."""
    size, traced = compiled.size, compiled.program.functions
    kept = [*range(size), size + ROW.index("strain")]
    chosen = [
        replace(traced[name], outputs=tuple(traced[name].outputs[i] for i in kept)) for name in ("init", "stress_step")
    ]
    loop = _RIDE.format(
        lanes=lanes,
        constants=max(1, len(compiled.program.hoisted_nodes)),
        size=size,
        inputs=max(size + 3, 4),
        results=size + 1,
    )
    write = c_source if lanes % BLOCK else lanes_source
    found = load_library(write(compiled.program, chosen) + loop)
    found.ride.argtypes = [ctypes.c_long, *[ctypes.c_void_p] * 3, ctypes.c_double, ctypes.c_void_p]
    return found


def by_simd(given: Case, compiled: CompiledLaw, values: Any) -> Callable[[], list[Any]]:
    """All lanes in C, `LANES` at a time; one array (steps, lanes) per chunk."""
    chunks, points = chunks_of(values), np.ascontiguousarray(given.points)
    ride, start = library(compiled, chunks[0].shape[1]).ride, np.array(given.start)

    def one(chunk: Any) -> Any:
        rows = np.empty((len(points), chunk.shape[1]))
        pointers = [a.ctypes.data for a in (chunk, start, points)]
        ride(len(points), *pointers, given.dt, rows.ctypes.data)
        return rows

    return lambda: [one(chunk) for chunk in chunks]
