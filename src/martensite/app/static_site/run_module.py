"""The C of a run as a WebAssembly module, from `simulate.marching_native` or `simulate.native`.

It includes heat capacity and loss of each element, which determine the first step (`simulate.api.longest_step`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.export.wasm.module import compile_sources, write_math
from martensite.kernels.c99 import c_source
from martensite.kernels.program import Program
from martensite.scenario.scenario import Scenario
from martensite.signals.base import AbstractWaveform
from martensite.simulate.accuracy import shares_stress
from martensite.simulate.adaptive import PER_STRESS
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.march_kernel import MarchKernel
from martensite.simulate.marching_native import DECIDED, RANGES
from martensite.simulate.native import march_source

WARMER = 50.0
"""Temperature rise at which `longest_step` evaluates the loss [K]."""
STRING = """#include <stddef.h>
void *memcpy(void *, const void *, size_t);
void *memset(void *, int, size_t);
"""
EXPORTED = {"march": ("march",), "march_on": ("march_on", "size_of_block", "observe_rows")}


@dataclass(frozen=True)
class RunSource:
    """The C of the runs of a structure."""

    march: str
    """`adaptive`, `fixed` or `given`."""
    run: str
    first: str
    """Heat capacities and losses, for the first step."""

    @property
    def digest(self) -> str:
        """Return the digest of the compiled sources."""
        text = "\0".join((self.march, self.run, self.first, write_math()))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def compile(self) -> bytes:
        """Return the module."""
        files = {"run.c": self.run, "first.c": self.first, "math.h": write_math(), "string.h": STRING}
        names = EXPORTED["march" if self.march == "given" else "march_on"]
        exported = [f"-Wl,--export={name}" for name in (*names, "list_losses")]
        return compile_sources(files, ["run.c", "first.c"], exported)


def can_step(scenario: Scenario) -> bool:
    """Return whether the page can run a scenario: from the default initial state, without a stored state."""
    return not (scenario.initial or scenario.restart_at)


def write_source(scenario: Scenario, waves: Sequence[AbstractWaveform]) -> RunSource:
    """Return the C of all scenarios with the structure of this one."""
    system = scenario.whole
    compiled = compile_march(system)
    outputs = tuple(range(len(compiled.outputs)))
    first = _write_losses(system, compiled)
    if system.sample_time():
        return RunSource("given", march_source(compiled, 1, outputs, bounded=len(compiled.envelope) > 0), first)
    fixed, tones = scenario.step is not None, max((len(wave.tones()) for wave in waves), default=0)
    kernel = MarchKernel(compiled, outputs, 1, tones, 2 if fixed else compiled.order, False, fixed)
    return RunSource("fixed" if fixed else "adaptive", kernel.source(), first)


def describe_layout(compiled: CompiledMarch, source: RunSource) -> dict[str, Any]:
    """Return the lengths of a module's arrays."""
    return {
        "march": source.march,
        "size": compiled.size,
        "drives": compiled.drives,
        "inputs": compiled.inputs,
        "places": compiled.signals_in_step(),
        "outputs": len(compiled.outputs),
        "recorded": sum(compiled.states_observed(range(len(compiled.outputs)))),
        "shares": shares_stress(compiled),
        "judged": len(compiled.convergence_scales),
        "envelope": len(compiled.envelope),
        "parameters": len(compiled.paths),
        "reports": len(compiled.report),
        "said": RANGES,
        "decided": DECIDED,
        "forks": compiled.forks,
        "perStress": PER_STRESS,
        "order": 2 if source.march != "adaptive" else compiled.order,
    }


def _write_losses(system: AbstractSystem, compiled: CompiledMarch) -> str:
    """Return C of heat capacity [J/K] and loss [W/K] of each element."""
    program = Program()
    numbers = {path: program.parameter(path) for path in compiled.paths}
    traced = system.rebuilt(numbers)

    def losses(xp: Any) -> list[Any]:
        entries: list[Any] = []
        for one in traced.actuators().values():
            warm = one.environment.temperature + WARMER
            lost = one.element.heat_loss(xp, warm, one.environment) / WARMER
            entries += [one.element.heat_capacity_total(), lost]
        return entries

    program.add("losses", (), losses)
    text = c_source(program, [program.functions["losses"]])
    return (
        f"{text}\nint list_losses(const double *p, double *y) {{\n    double c[{program.constants}], x[1] = {{0.0}};\n"
        f"    k_prepare(1, p, c);\n    k_losses(1, c, x, y);\n    return {2 * len(traced.actuators())};\n}}\n"
    )
