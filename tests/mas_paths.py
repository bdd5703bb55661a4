"""Bare laws of layers in wells on prescribed paths of stress or strain, traced once per structure.

Paths run in C, or in plain floats where there is no compiler; that all
runtimes agree is tested elsewhere. `TABLE_1` is the single crystal of the finger prototype
(material `finger-mas`).
"""

from __future__ import annotations

import ctypes
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from martensite.base.parameters import describe_structure
from martensite.kernels import floats
from martensite.kernels.c99 import c_source
from martensite.kernels.compiler import find_compiler, load_library
from martensite.kernels.nested import flatten_numbers
from martensite.kernels.program import Program
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.coupling import advance_memory
from martensite.physics.laws.mas import MullerAchenbachSeelecke

TABLE_1 = {
    "E_A": 50e9,
    "E_M": 30e9,
    "eps_T": 0.04,
    "sigma_L": 1e6,
    "T_L": 320.0,
    "dsigma_dT": 4e6,
    "Delta_sigma": 52e6,
    "layer_volume": 5e-23,
    "layer_time": 1e-2,
}


def table_1(cls: Any = MullerAchenbachSeelecke, **changes: Any) -> Any:
    """A law with the numbers of Table 1; keyword arguments replace numbers and options."""
    return cls(**(TABLE_1 | changes))


class Point(NamedTuple):
    """A corner of a path; between corners everything runs straight."""

    time: float
    """[s]"""
    value: float
    """Stress [Pa] or strain [-]."""
    temperature: float
    """[K]"""


class Path(NamedTuple):
    """What a law answers at the ends of all steps, and at the start."""

    time: Any
    stress: Any
    temperature: Any
    strain: Any
    plus: Any
    minus: Any
    residual: float
    """Largest mismatch of the solves; 0 under prescribed stress."""


_PROGRAMS: dict[Any, Any] = {}


def traced(law: Any) -> Any:
    """A program for a law, and the numbers of the law that it takes."""
    key = describe_structure(law)
    if key not in _PROGRAMS:
        _PROGRAMS[key] = _trace(law)
    program, paths = _PROGRAMS[key]
    known = {leaf.path: leaf.value for leaf in law.leaves()}
    return program, [known[path] for path in paths]


_MARCH = """
void march(long steps, const double *p, const double *start, const double *rows, double *y) {{
    double c[{constants}], x[{inputs}];
    k_prepare(1, p, c);
    memcpy(x, start, {size} * sizeof(double));
    for (long k = 0; k < steps; k++, y += {outputs}) {{
        memcpy(x + {size}, rows + 3 * k, 3 * sizeof(double));
        k_{control}(1, c, x, y);
        memcpy(x, y, {size} * sizeof(double));
    }}
}}
"""


_LIBRARIES: dict[Any, Any] = {}


def library(program: Program, control: str) -> Any:
    """The steps of a whole path in C."""
    key = id(program), control  # programs are kept
    if key not in _LIBRARIES:
        _LIBRARIES[key] = _built(program, control)
    return _LIBRARIES[key]


def _built(program: Program, control: str) -> Any:
    function = program.functions[control]
    march = _MARCH.format(
        constants=max(1, len(program.hoisted_nodes)),
        inputs=len(function.inputs),
        outputs=len(function.outputs),
        size=len(function.inputs) - 3,
        control=control,
    )
    return load_library(c_source(program, [function]) + march)


def marched(law: Any, control: str, start: Any, rows: np.ndarray) -> np.ndarray:
    """What a law answers to rows of value, temperature and length of step: one row each."""
    program, values = traced(law)
    if find_compiler() is None:
        return stepped(program.bind_floats(*values)[control], start, rows)
    found = np.empty((len(rows), len(program.functions[control].outputs)))
    arrays = [np.array(a, dtype=float) for a in (values, start, rows)]
    pointers: Any = [a.ctypes.data_as(ctypes.c_void_p) for a in (*arrays, found)]
    library(program, control).march(ctypes.c_long(len(rows)), *pointers)
    return found


def stepped(advance_by: Any, start: Any, rows: np.ndarray) -> np.ndarray:
    """The same in plain floats."""
    found, numbers = [], list(start)
    for row in rows.tolist():
        found.append(advance_by(*numbers, *row))
        numbers = found[-1][: len(numbers)]
    return np.array(found)


def _trace(law: Any) -> tuple[Program, list[str]]:
    program, paths = Program(), [leaf.path for leaf in law.leaves()]
    twin = law.rebuilt({path: program.parameter(path) for path in paths})
    example = law.init(floats, Fractions(0.5, 0.5), 0.0, 300.0)
    names = [f"m{i}" for i in range(len(flatten_numbers(example)))]

    def answers(xp: Any, memory: Any, residual: Any) -> list[Any]:
        found = twin.fractions(memory)
        strain = twin.strain(xp, found, memory.stress, memory.temperature)
        return [*flatten_numbers(memory), strain, *found, residual]

    def by_stress(xp: Any, *inputs: Any) -> list[Any]:
        *numbers, stress, temperature, dt = inputs
        memory, _ = twin.kinetics(xp, rebuilt(example, iter(numbers)), stress, temperature, dt)
        return answers(xp, memory, 0.0)

    def by_strain(xp: Any, *inputs: Any) -> list[Any]:
        *numbers, strain, temperature, dt = inputs

        def settle(xp: Any, fractions: Fractions) -> tuple[Any, Any]:
            free = twin.free_strain(xp, fractions, temperature)
            return (strain - free) / twin.compliance(xp, fractions), temperature

        memory, report = advance_memory(xp, twin, rebuilt(example, iter(numbers)), settle, dt)
        return answers(xp, memory, report.residual)

    for name, kernel in (("stress", by_stress), ("strain", by_strain)):
        program.add(name, [*names, "value", "temperature", "dt"], kernel)
    return program, paths


def rebuilt(example: Any, numbers: Any) -> Any:
    """Nested tuples like the example from an iterator of numbers."""
    if not isinstance(example, tuple):
        return next(numbers)
    items = [rebuilt(item, numbers) for item in example]
    return tuple(items) if type(example) is tuple else type(example)(*items)


def follow(law: Any, start: tuple[float, float], corners: list[Any], step: float, control: str = "stress") -> Path:
    """The law from (x₊, x₋) along straight lines through corners (time, value, temperature).

    `control` says whether the values are stresses [Pa] or strains [-]; a strain-driven path
    starts at the stress that its first strain needs.
    """
    fractions = Fractions(start[0] + start[1], start[0] - start[1])
    first = Point(*corners[0])
    stress = first.value
    if control == "strain":
        free = law.free_strain(floats, fractions, first.temperature)
        stress = (first.value - free) / law.compliance(floats, fractions)
    memory = law.init(floats, fractions, stress, first.temperature)
    numbers: Any = flatten_numbers(memory)
    size = len(numbers)
    strain = law.strain(floats, fractions, stress, first.temperature)
    times, rows = [first.time], []
    for a, b in pairwise(Point(*corner) for corner in corners):
        count = max(1, round((b.time - a.time) / step))
        for k in range(1, count + 1):
            t, value, temperature = (p + (q - p) * k / count for p, q in zip(a, b, strict=True))
            times.append(t)
            rows.append((value, temperature, (b.time - a.time) / count))
    begin = [*numbers[-2:], strain, *fractions, 0.0]
    found = marched(law, control, numbers, np.array(rows))[:, size - 2 :]
    t = np.array(times)
    stress, temperature, strain, martensite, oriented, residual = np.vstack([begin, found]).T
    half = 0.5 * (martensite + oriented), 0.5 * (martensite - oriented)
    return Path(t, stress, temperature, strain, *half, float(residual.max()))


def there_and_back(most: float, rate: float, temperature: float) -> list[Point]:
    """Corners of a path from 0 to `most` and back at a rate per second."""
    seconds = most / rate
    return [Point(0.0, 0.0, temperature), Point(seconds, most, temperature), Point(2 * seconds, 0.0, temperature)]
