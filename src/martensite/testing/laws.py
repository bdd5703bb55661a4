"""Suite for laws: bounds, independence of step cuts, monotony, dissipation, finite results."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.base.parameters import StructureKey
from martensite.kernels import floats
from martensite.kernels.arrays import ArrayNamespace
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.testing.conformance import require_condition

Point = tuple[float, float]
PATHS = 24
CELSIUS = 273.15
AROUND = 40.0
"""Temperature margin around the law's own temperatures [K]."""
TAIL = 0.01
"""Martensite fraction that laws with exponential kinetics keep at their nominal finish line."""


def trace_kinetics(law: AbstractLaw) -> Callable[[Any, float, float, float], Any]:
    """Return `kinetics` as a function (memory, stress, temperature, dt) -> memory, traced for speed."""
    kinetics, _, shape = _bind_law(law)
    return lambda memory, *point: shape.rebuild(kinetics(*flatten_numbers(memory), *point))


def _bind_law(law: AbstractLaw) -> tuple[Callable[..., Sequence[float]], Callable[..., Sequence[float]], NestedShape]:
    """Return traced kinetics and strain on flat memories, and the shape of a memory."""
    bind, shape = _trace_law(StructureKey(law))
    functions = bind(*(leaf.value for leaf in law.leaves()))
    return functions["kinetics"], functions["strain"], shape


@cache_answers(64)
def _trace_law(keyed: StructureKey[Any]) -> Any:
    program = Program()
    law = keyed.part.rebuilt({leaf.path: program.parameter(leaf.path) for leaf in keyed.part.leaves()})
    shape = NestedShape(keyed.part.init(floats, Fractions(1.0, 1.0), 0.0, 300.0))

    def kinetics(xp: Any, *arguments: Any) -> list[Any]:
        *numbers, stress, temperature, dt = arguments
        return flatten_numbers(law.kinetics(xp, shape.rebuild(numbers), stress, temperature, dt)[0])

    def strain(xp: Any, *numbers: Any) -> list[Any]:
        memory = shape.rebuild(numbers)
        return [law.strain(xp, law.fractions(memory), memory.stress, memory.temperature)]

    names = [f"m{i}" for i in range(len(flatten_numbers(shape.example)))]
    program.add("kinetics", [*names, "stress", "temperature", "dt"], kinetics)
    program.add("strain", names, strain)
    return program.bind_floats, shape


def follow_path(
    law: AbstractLaw, points: Sequence[Point], fraction: float, substeps: int = 1, dt: float = 1.0
) -> list[Any]:
    """Return the memories of a law at the points (stress [Pa], temperature [K]) of a path.

    Args:
        law: the law.
        points: corners of the path, joined by straight legs.
        fraction: martensite fraction at the first point, all oriented.
        substeps: equal steps per leg.
        dt: duration of a leg [s].
    """
    memories = [law.init(floats, Fractions(fraction, fraction), *points[0])]
    kinetics, _, shape = _bind_law(law)
    numbers: Sequence[float] = flatten_numbers(memories[0])
    for (s0, t0), (s1, t1) in pairwise(points):
        for k in range(1, substeps + 1):
            share = k / substeps
            stress = s1 if k == substeps else s0 + share * (s1 - s0)
            temperature = t1 if k == substeps else t0 + share * (t1 - t0)
            numbers = kinetics(*numbers, stress, temperature, dt / substeps)
        memories.append(shape.rebuild(numbers))
    return memories


def find_end(
    law: AbstractLaw, points: Sequence[Point], fraction: float, substeps: int = 1, dt: float = 1.0
) -> Fractions:
    """Return the fractions at the end of a path; see `follow_path`."""
    return law.fractions(follow_path(law, points, fraction, substeps, dt)[-1])


def find_strain(law: AbstractLaw, memory: Any) -> float:
    """Return the strain [-] of a memory."""
    return law.strain(floats, law.fractions(memory), memory.stress, memory.temperature)


def depends_on_time(law: AbstractLaw) -> bool:
    """Return whether a law is rate-dependent."""
    legs = [(0.0, 290.0), (0.0, 360.0), (300e6, 330.0), (50e6, 330.0)]
    slow, fast = (find_end(law, legs, 0.5, dt=dt) for dt in (1e3, 1e-3))
    return slow != fast


@cache_answers(1)
def _draw_paths() -> list[tuple[list[Point], float]]:
    rng = np.random.default_rng(7)
    paths: list[tuple[list[Point], float]] = []
    for _ in range(PATHS):
        count = int(rng.integers(2, 6))
        stress, kelvin = rng.uniform(0.0, 500e6, count), rng.uniform(270.0, 420.0, count)
        start = float(rng.integers(0, 2)) if rng.random() < 0.5 else float(rng.random())
        paths.append((list(zip(stress.tolist(), kelvin.tolist(), strict=True)), start))
    return paths


def _describe_path(points: Sequence[Point]) -> str:
    return ", ".join(f"({s / 1e6:.1f} MPa, {t - CELSIUS:.1f} °C)" for s, t in points)


def check_memory(law: AbstractLaw) -> None:
    """A memory starts with the given fractions, stress and temperature."""
    memory = law.init(floats, Fractions(0.4, 0.4), 30e6, 310.0)
    fractions = law.fractions(memory)
    equal = abs(fractions.martensite - 0.4) < 1e-12 and abs(fractions.oriented - 0.4) < 1e-12
    require_condition(equal, f"`init` is told a fraction of 0.4, but `fractions` of it gives {fractions}.")
    there = (memory.stress, memory.temperature)
    require_condition(there == (30e6, 310.0), f"`init` is told 30 MPa and 310 K, but remembers {there}.")


def check_affine_strain(law: AbstractLaw) -> None:
    """At fixed fractions the strain is affine in stress, with a positive compliance."""
    for fraction in (0.0, 0.5, 1.0):
        frozen = Fractions(fraction, fraction)
        strains = [law.strain(floats, frozen, s, 310.0) for s in (0.0, 100e6, 200e6)]
        slope = law.compliance(floats, frozen)
        require_condition(slope > 0.0, f"The compliance at a fraction of {fraction} is {slope}.")
        free = law.free_strain(floats, frozen, 310.0)
        expected = [free + s * slope for s in (0.0, 100e6, 200e6)]
        affine = np.allclose(strains, expected, rtol=1e-9, atol=1e-14)
        require_condition(affine, f"At a fraction of {fraction} `strain` is not free strain + compliance · σ.")


def check_bounds(law: AbstractLaw) -> None:
    """Fractions stay between 0 and 1, and the oriented fraction never exceeds the martensite."""
    for points, start in _draw_paths():
        for memory in follow_path(law, points, start):
            fractions = law.fractions(memory)
            bounded = 0.0 <= fractions.martensite <= 1.0 and abs(fractions.oriented) <= (fractions.martensite + 1e-12)
            bounded = bounded and 0.0 <= fractions.rphase <= 1.0
            require_condition(bounded, f"On the path {_describe_path(points)} the fractions are {fractions}.")
            share = law.trained_share(floats, memory.stress)
            require_condition(
                0.0 <= share <= 1.0, f"At {memory.stress:.3g} Pa the share `trained_share` is {share:.6g}."
            )


def check_standstill(law: AbstractLaw) -> None:
    """A step to the same point in zero time changes nothing."""
    for points, start in _draw_paths():
        memory = follow_path(law, points, start)[-1]
        again, fractions = law.kinetics(floats, memory, *points[-1], 0.0)
        same = again == memory and fractions == law.fractions(memory)
        require_condition(same, f"At the end of {_describe_path(points)} standing still changes the memory.")


def check_clock(law: AbstractLaw) -> None:
    """A law with a history rule is rate-independent."""
    both = depends_on_time(law) and "history" in law.declarations
    require_condition(not both, "The law has a history rule, but depends on how long a move takes.")


def check_cuts(law: AbstractLaw) -> None:
    """A rate-independent law gives the same result for any division of a path into steps."""
    if depends_on_time(law):
        return
    for number, (points, start) in enumerate(_draw_paths()):
        whole = find_end(law, points, start)
        for substeps in (7, 20) if number % 4 == 0 else (7,):  # many cuts of a path cost as much as three others
            cut = find_end(law, points, start, substeps)
            apart = max(abs(a - b) for a, b in zip(whole, cut, strict=True))
            require_condition(
                apart < 1e-11,
                f"The path {_describe_path(points)} in {substeps} steps a leg ends {apart:.1e} away from where it "
                "ends in one.",
            )


def check_minor_loops(law: AbstractLaw) -> None:
    """With return-point memory, loops without stress close within each other."""
    if getattr(law, "history", "") != "return-point":
        return
    own = {name: law.value_of(name) for name in ("M_f", "M_s", "A_s", "A_f")}
    hot, cold = own["A_f"] - own["A_s"], own["M_s"] - own["M_f"]
    shares = (0.8, 0.7, 0.6, 0.6, 0.5, 0.5, 0.5, 0.6, 0.6, 0.7, 0.8)  # of either strip in turn, inwards and out again
    turns = [own["A_s"] + x * hot if k % 2 == 0 else own["M_s"] - x * cold for k, x in enumerate(shares)]
    memories = follow_path(law, [(0.0, own["M_f"] - AROUND), *((0.0, t) for t in turns)], 1.0)[1:]
    for early, late in ((4, 6), (3, 7), (2, 8), (1, 9), (0, 10)):
        apart = abs(law.fractions(memories[early]).martensite - law.fractions(memories[late]).martensite)
        require_condition(apart < 1e-9, f"A loop from {turns[early] - CELSIUS:.1f} °C on stays open by {apart:.1e}.")


def check_direction(law: AbstractLaw) -> None:
    """Without stress, heating removes martensite and cooling produces it."""
    own = [leaf.value for leaf in law.leaves() if leaf.declared.unit == "K" and leaf.value > 0.0]
    low, high = min([290.0, *own]) - AROUND, max([440.0, *own]) + AROUND
    up = [(0.0, float(t)) for t in range(max(int(low), 1), int(high) + 1)]
    for way, start, sign in ((up, 1.0, -1.0), (up[::-1], 0.0, 1.0)):
        memories = follow_path(law, way, start, dt=1e3)
        fractions = [law.fractions(memory).martensite for memory in memories]
        steps = sign * np.diff(fractions)
        words = "heating" if sign < 0.0 else "cooling"
        worst = int(np.argmin(steps))
        require_condition(
            steps.min() >= -1e-6,
            f"On {words} from {way[0][1] - CELSIUS:.0f} °C the martensite fraction goes the wrong "
            f"way at {way[worst][1] - CELSIUS:.0f} °C.",
        )
        require_condition(
            abs(fractions[-1] - (1.0 - start)) <= TAIL,
            f"On {words} to {way[-1][1] - CELSIUS:.0f} °C the martensite fraction ends at "
            f"{fractions[-1]:.3g} instead of {1.0 - start:.0f}.",
        )


def check_stiffness(law: AbstractLaw) -> None:
    """The strain after a step does not fall with its stress."""
    count, rng, paths = 101, np.random.default_rng(8), _draw_paths()
    ends = [follow_path(law, points, start)[-1] for points, start in paths]
    pairs = [(end.temperature, float(rng.uniform(270.0, 420.0))) for end in ends]
    kelvins: Any = np.repeat(pairs, count)  # one call on arrays is cheaper
    stresses: Any = np.tile(np.linspace(0.0, 500e6, count), len(pairs) * 2)
    lanes = [np.repeat(numbers, 2 * count) for numbers in zip(*map(flatten_numbers, ends), strict=True)]
    xp, memory = ArrayNamespace(np), NestedShape(ends[0]).rebuild(lanes)
    _, after = law.kinetics(xp, memory, stresses, kelvins, 1.0)
    strains: Any = law.strain(xp, after, stresses, kelvins)
    falls = np.diff(strains.reshape(-1, count)) < -1e-14
    row, place = divmod(int(np.argmax(falls)), count - 1)
    require_condition(
        not falls.any(),
        f"After {_describe_path(paths[row // 2][0])}, at {pairs[row // 2][row % 2] - CELSIUS:.1f} °C, the strain "
        f"falls near {stresses[place] / 1e6:.0f} MPa as the stress grows.",
    )


def find_austenite(law: AbstractLaw) -> float:
    """Return the lowest whole temperature [K] without martensite at zero stress.

    Raises:
        ConformanceError: martensite remains at 480 K.
    """
    kinetics, _, shape = _bind_law(law)
    cold = flatten_numbers(law.init(floats, Fractions(1.0, 1.0), 0.0, 250.0))
    for kelvin in map(float, range(280, 480)):
        if law.fractions(shape.rebuild(kinetics(*cold, 0.0, kelvin, 1e3))).martensite <= TAIL:
            return kelvin
    require_condition(False, "Martensite without stress is still there at 207 °C.")
    return 480.0


def find_work(law: AbstractLaw, kelvin: float, stresses: Sequence[float]) -> tuple[float, float]:
    """Return ∮ σ dε [J/m³] along an isotherm in steps of about 2 MPa, and the final martensite fraction."""
    kinetics, strain_of, shape = _bind_law(law)
    numbers: Sequence[float] = flatten_numbers(law.init(floats, Fractions(0.0, 0.0), stresses[0], kelvin))
    total, last_stress, (last_strain,) = 0.0, stresses[0], strain_of(*numbers)
    for a, b in pairwise(stresses):
        for sigma in np.linspace(a, b, 2 + int(abs(b - a) / 2e6)).tolist()[1:]:
            numbers = kinetics(*numbers, sigma, kelvin, 1.0)
            (strain,) = strain_of(*numbers)
            total += 0.5 * (sigma + last_stress) * (strain - last_strain)
            last_stress, last_strain = sigma, strain
    return total, law.fractions(shape.rebuild(numbers)).martensite


def check_dissipation(law: AbstractLaw) -> None:
    """A closed cycle at constant temperature above A_f dissipates work."""
    rng, hot = np.random.default_rng(9), find_austenite(law) + 1.0
    for _ in range(5):
        turns = rng.uniform(0.0, 500e6, int(rng.integers(1, 7))).tolist()
        kelvin = hot + float(rng.uniform(0.0, 5.0))
        total, left = find_work(law, kelvin, [0.0, *turns, 0.0])
        require_condition(left <= TAIL, f"At {kelvin - CELSIUS:.1f} °C martensite is left without stress.")
        require_condition(total >= -50.0, f"A cycle at {kelvin - CELSIUS:.1f} °C gives {-total:.3g} J/m³.")
    large, _ = find_work(law, hot + 1.0, [0.0, 600e6, 0.0])
    require_condition(large > 1e5, f"A cycle to 600 MPa above A_f takes {large:.3g} J/m³ only.")


def check_extremes(law: AbstractLaw) -> None:
    """For any stress, temperature and time, results are finite."""
    count = 4_000
    rng, xp = np.random.default_rng(1), ArrayNamespace(np)
    xi: Any = np.where(rng.random(count) < 0.3, rng.integers(0, 2, count), rng.random(count))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        memory = law.init(xp, Fractions(xi, xi), *_draw_extremes(law, rng, count))
        for dt in (1e-3, 0.0, 10.0, 1e-9):
            s, t = _draw_extremes(law, rng, count)
            still = rng.random(count) < 0.1
            s, t = np.where(still, memory.stress, s), np.where(still, memory.temperature, t)
            memory, fractions = law.kinetics(xp, memory, s, t, dt)
            for number in (*flatten_numbers(memory), *fractions, law.strain(xp, fractions, s, t)):
                lost = ~np.isfinite(np.broadcast_to(number, count))
                place = int(np.argmax(lost))
                require_condition(
                    not lost.any(), f"A move to {s[place]:.3g} Pa and {t[place]:.3g} K gives no finite number."
                )


def _draw_extremes(law: AbstractLaw, rng: Any, count: int) -> tuple[Any, Any]:
    """Return stresses and temperatures, a third of them extreme or equal to parameters of the law."""
    own = {"K": [0.0, 1e-300, CELSIUS, 1e5], "Pa": [0.0, -1e9, 1e12, 1e-300, -1e-300]}
    for leaf in law.leaves():
        if leaf.declared.unit in own:
            own[leaf.declared.unit].append(leaf.value)
    absurd = rng.random((2, count)) < 1 / 3
    s = np.where(absurd[0], rng.choice(own["Pa"], count), rng.uniform(0.0, 500e6, count))
    t = np.where(absurd[1], rng.choice(own["K"], count), rng.uniform(250.0, 450.0, count))
    return s, t
