"""Tracing a law alone: a material point driven by stress or by strain, cached by structure.

Functions over the flat memory m of a law:

    init(ξ, ξ_S, σ, T),    stress_step(m…, σ, T, dt),    strain_step(m…, ε, T, dt)

all return the memory and then what `ROW` names. Given a strain, the stress at the end of a step
follows from the fractions there,

    σ = [ε - ε_free(ξ, ξ_S, T)] · E(ξ),    at least 0 if tension only,

and the step is the fixed point of `laws.coupling`. Numbers never enter the trace.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from martensite.base.parameters import StructureKey, values_at
from martensite.kernels import floats
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program
from martensite.physics.kinetics.return_points import DEPTH
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.coupling import advance_memory

ROW = ("martensite", "oriented", "strain", "stress", "residual")
"""Values that every function returns after the memory: [-], [-], [-], [Pa], [-]."""
AUSTENITE = Fractions(0.0, 0.0)
FORGOTTEN = 1e-6
"""Smallest reported change of a fraction by forgotten loops."""


@dataclass(frozen=True, eq=False)
class CompiledLaw:
    """Traced law with functions `init`, `stress_step` and `strain_step` over flat memories."""

    program: Program
    paths: tuple[str, ...]
    """Parameter paths in program order."""
    size: int
    """Number of memory variables."""

    def values(self, law: AbstractLaw) -> list[float]:
        """Return the parameter values of a law of this structure, in program order."""
        return values_at(law, self.paths)


def compile_law(law: AbstractLaw, *, tension_only: bool = True) -> CompiledLaw:
    """Return the traced program of a law, cached by structure.

    With `tension_only` a strain-driven point goes slack instead of being compressed.
    """
    return _compile_keyed(StructureKey(law), tension_only)


@cache_answers(64)
def _compile_keyed(keyed: StructureKey[AbstractLaw], tension_only: bool) -> CompiledLaw:
    program = Program()
    paths = tuple(leaf.path for leaf in keyed.part.leaves())
    law = keyed.part.rebuilt({path: program.parameter(path) for path in paths})
    memories: list[Any] = []

    def init(xp: Any, martensite: Any, oriented: Any, stress: Any, temperature: Any) -> list[Any]:
        memory = law.init(xp, Fractions(martensite, oriented), stress, temperature)
        memories.append(memory)
        return _build_row(xp, law, memory, 0.0)

    program.add("init", ["xi", "xi_S", "sigma", "T"], init)
    shape, size = NestedShape(memories[0]), len(flatten_numbers(memories[0]))
    names = [f"m{i}" for i in range(size)]
    program.add("stress_step", [*names, "sigma", "T", "dt"], _stress_step(law, shape))
    program.add("strain_step", [*names, "eps", "T", "dt"], _strain_step(law, shape, tension_only))
    return CompiledLaw(program, paths, size)


def _build_row(xp: Any, law: AbstractLaw, memory: Any, residual: Any) -> list[Any]:
    fractions = law.fractions(memory)
    strain = law.strain(xp, fractions, memory.stress, memory.temperature)
    return [*flatten_numbers(memory), *fractions[:2], strain, memory.stress, residual]


def _stress_step(law: AbstractLaw, shape: NestedShape) -> Callable[..., list[Any]]:
    def step(xp: Any, *arguments: Any) -> list[Any]:
        *numbers, stress, temperature, dt = arguments
        after, _ = law.kinetics(xp, shape.rebuild(numbers), stress, temperature, dt)
        return _build_row(xp, law, after, 0.0)

    return step


def _strain_step(law: AbstractLaw, shape: NestedShape, tension_only: bool) -> Callable[..., list[Any]]:
    def step(xp: Any, *arguments: Any) -> list[Any]:
        *numbers, strain, temperature, dt = arguments

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            elastic = strain - law.free_strain(xp, fractions, temperature)
            stress = elastic / law.compliance(xp, fractions)
            return (xp.maximum(stress, 0.0) if tension_only else stress), temperature

        after, report = advance_memory(xp, law, shape.rebuild(numbers), settle, dt)
        return _build_row(xp, law, after, report.residual)

    return step


NOTICEABLE = 5e6
"""Smallest reported compression [Pa]."""


def describe_compression(law: AbstractLaw, stress: Sequence[float]) -> list[str]:
    """Return a warning for compression with a law for tension only."""
    least = float(min(stress))
    if not law.tension_only or least > -NOTICEABLE:
        return []
    remedy = '; try `compression = "symmetric"` of the law' if "compression" in law.declarations else ""
    return [
        f"Caution: the stress falls to {least / 1e6:.4g} MPa, but `{law.registered_name}` knows tension only, and "
        f"compression drives its martensite back{remedy}."
    ]


def describe_forgotten_loops(
    law: AbstractLaw,
    stress: Sequence[float],
    temperature: Sequence[float],
    martensite: Sequence[float],
    oriented: Sequence[float],
) -> list[str]:
    """Return a warning if a law of bounded memory forgot loops on a sampled path.

    The path is repeated between the turning points of the martensite fraction.

    Args:
        law: any law.
        stress: along the path [Pa].
        temperature: along the path [K].
        martensite: the fraction that was found [-].
        oriented: the net oriented one [-].
    """
    start = Fractions(martensite[0], oriented[0])
    memory = law.init(floats, start, stress[0], temperature[0])
    if law.find_forgotten_change(memory) is None:
        return []
    steps = [(k, after - before) for k, (before, after) in enumerate(pairwise(martensite)) if after != before]
    turns = [k + 1 for (k, before), (_, after) in pairwise(steps) if before * after < 0.0]
    compiled, shape = compile_law(law), NestedShape(memory)
    step = compiled.program.bind_floats(*compiled.values(law))["stress_step"]
    numbers = flatten_numbers(memory)
    for k in (*turns, len(martensite) - 1):
        numbers = step(*numbers, stress[k], temperature[k], 0.0)[: compiled.size]
    lost = law.find_forgotten_change(shape.rebuild(numbers))
    if lost is None or not lost > FORGOTTEN:
        return []
    return [
        f"Caution: more than {DEPTH} loops lay within each other, and those that the law forgot change the martensite "
        f"fraction by up to {lost:.1e}; see the rule `return-point`."
    ]
