"""C source and compiled library of the time integration of a system.

`marching.c` with `adaptive.c` or `fixed.c`, and the kernels of the system with one lane or several.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any

from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.kernels.c99 import c_source
from martensite.kernels.c99_lanes import lanes_source
from martensite.kernels.compiler import is_compiled, load_library, read_source
from martensite.kernels.compute_once import cache_answers
from martensite.signals.base import AbstractWaveform
from martensite.simulate import adaptive, step_trials
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.forks import COUNTS, ROUNDED
from martensite.simulate.ledger import EMPTY, STORES, TURNED_OVER, Book
from martensite.simulate.marching import MarchPlan
from martensite.simulate.recorded_track import record_width

SHARED = (
    *("STEP_TOLERANCE", "SHORTEST", "SOLVED", "SAFETY", "LEAST_CHANGE", "MOST_CHANGE", "SWING", "PRESCRIBED"),
    *("BEND", "LEAP", "TURN", "KINK_MARGIN", "HIDDEN", "EDGE"),
    *("STIFF", "LEAST_SMOOTH", "SMOOTH_PHASE", "SMOOTH_TOLERANCE", "LEAST_SHRINK", "MOST_GROWTH", "BEYOND"),
    *("NEAREST", "ACROSS", "AGAIN", "EVENT_TURNS", "LINES", "REACH"),
    *("SHORT", "BESIDE", "BETWEEN", "ROUNDING", "CUBIC", "PER_STRESS", "LEAST_FALL", "TRACED"),
)
"""Constants shared with the implementation on floats, under the same names."""
FUSED = ("-ffp-contract=fast",)
"""Compiler flags for runs with step size control: fused products and sums.

Runs on given steps round as on floats.
"""
SINGLE = ("-fno-tree-slp-vectorize", "-fno-if-conversion")
"""Compiler flags for one run.

Vectors of a few of its numbers stall, since these numbers were just stored. A predicted branch ends a chain of
operations, which the choice of a value extends.
"""


def kernel_of(
    plan: MarchPlan, outputs: Sequence[int], lanes: int = 1, own: Sequence[Sequence[AbstractWaveform]] | None = None
) -> MarchKernel:
    """Return the kernel for runs of a plan, optionally with individual waveforms."""
    rows = [plan.waveforms] if own is None else own
    tones = max((len(waveform.tones()) for row in rows for waveform in row), default=0)
    fixed = plan.step is not None
    order = 2 if fixed else plan.order
    return MarchKernel(plan.compiled, tuple(outputs), lanes, tones, order, own is not None, fixed)


@dataclass(frozen=True)
class MarchKernel:
    """Key of a compiled library."""

    compiled: CompiledMarch
    outputs: tuple[int, ...]
    lanes: int
    tones: int
    """Largest number of tones of a drive."""
    order: int = 2
    own: bool = False
    """True if every run has individual drives."""
    fixed: bool = False
    """True if the steps are given."""

    @property
    def flags(self) -> tuple[str, ...]:
        """Return additional compiler flags."""
        if self.fixed:
            return ()
        return FUSED if self.lanes > 1 else FUSED + SINGLE

    def source(self) -> str:
        """Return the C source."""
        book = EMPTY if self.fixed or self.lanes > 1 else self.compiled.book  # batches report no balance
        control = ["fixed"] if self.fixed else ["surface", "lengths", "kinks", "samples", "forks", "adaptive"]
        ledger = [] if book is EMPTY else ["ledger"]
        names = ["marching", "drives", "totals", "runs", *ledger, *control, "track"]
        known = vars(step_trials) | vars(adaptive)
        shared = {name: known[name] for name in SHARED}
        constants = self._list_sizes() | self._describe_places() | self._describe_book(book) | shared
        texts = (read_source("simulate", f"{name}.c", {}) for name in names)
        return "\n".join([self._print_kernels(book), read_source("signals", "reader.c", constants), *texts])

    def _list_sizes(self) -> dict[str, Any]:
        """Return the sizes of the system and of its arrays."""
        compiled = self.compiled
        return {
            "LANES": self.lanes,
            "SIMD": '_Pragma("omp simd")' if self.lanes > 1 else "",
            "SIZE": compiled.size,
            "DRIVES": compiled.drives,
            "INPUTS": compiled.inputs,
            "OUTPUTS": len(self.outputs),
            "RECORDED": record_width(compiled.drives, sum(compiled.states_observed(self.outputs))),
            "JUDGED": len(compiled.convergence_scales),
            "ENVELOPE": len(compiled.envelope),
            "HEATED": len(compiled.heated),
            "CONSTANTS": compiled.program.constants,
            "PARAMETERS": len(compiled.paths),
            "ORDER": self.order,
            "TONES": self.tones,
            "OWN": int(self.own),
            "JUDGE_SIGNALS": int(compiled.asks_for_signals("judge")),
            "OBSERVE_SIGNALS": int(compiled.asks_for_signals("observe", self.outputs)),
        }

    def _describe_places(self) -> dict[str, Any]:
        """Return the places of kinks, forks, rates and judged outputs; given steps need no kinks, forks and rates."""
        compiled = self.compiled
        places, rates, forks = ((), (), ()) if self.fixed else (compiled.points, compiled.rates, compiled.forks)
        sizes = [place.size for place in places]
        return {
            "POINTS": len(places),
            "PARTS": _format_list([p.fraction for p in places]),
            "WEIGHTS": _format_list([p.weight for p in places]),
            "NUMBERS": sum(sizes),
            "SIZES": _format_list(sizes),
            "START": _format_list(list(accumulate(sizes, initial=0))[:-1]),
            "FORKS": len(forks),
            "FORK_PARTS": _format_list([f.fraction for f in forks]),
            "FORK_WEIGHTS": _format_list([f.weight for f in forks]),
            "COUNTS": COUNTS,
            "ROUNDED": ROUNDED,
            "RATES": len(rates),
            "PLACES_OF_RATES": _format_list(rates),
            "WIDTHS": _format_list(compiled.widths),
            "PLACES": _format_list(compiled.heated),
            "LEAST": _format_list([least for _, least in compiled.convergence_scales]),
            "OBSERVED": _format_list(compiled.states_observed(self.outputs)),
        }

    def _describe_book(self, book: Book) -> dict[str, Any]:
        """Return the entries of a ledger, and the functions that read signals after a step."""
        compiled = self.compiled
        return {
            "LEDGER": int(book is not EMPTY),
            "ENTRIES": book.size,
            "HELD": len(book.energies),
            "EFFORTS": len(book.efforts),
            "BALANCED": int(book.has_heat_balance),
            "FLOWS": len(compiled.program.functions["flows"].outputs),
            "ACCOUNTS": len(ACCOUNTS),
            "ACCOUNT_OF": _format_list([*book.energies, *book.efforts]),
            "STORE_OF": _format_list([STORES[account] for account in book.energies]),
            "TURNED_OVER": _format_list([int(account in TURNED_OVER) for account in book.efforts]),
            "FOLLOWS": int(compiled.follows and not self.fixed),
            "ENTRY_SIGNALS": int(compiled.asks_for_signals("entries")),
        }

    def _print_kernels(self, book: Book) -> str:
        """Return the C source of the traced functions."""
        compiled, traced = self.compiled, self.compiled.program.functions
        solve = {4: ["rosenbrock"], 5: ["surface", "events", "solve"]}.get(self.order, ["solve"])
        names = ["step"] if self.fixed else [*solve, "ripple", "points"]
        names += ["forks"] if compiled.forks and not self.fixed else []
        names += [] if book is EMPTY else ["flows", "entries"]
        functions = [traced[name] for name in ("init", "judge", *names)]
        observe = traced["observe"]
        wanted = tuple(observe.outputs[i] for i in self.outputs)
        functions.append(replace(observe, outputs=wanted))
        if self.lanes == 1:
            return c_source(compiled.program, functions, not self.fixed, single=True)
        return lanes_source(compiled.program, functions)


_LOADED: set[MarchKernel] = set()


@cache_answers(4)
def _write_source(kernel: MarchKernel) -> str:
    """Return the C source of a kernel, cached."""
    return kernel.source()


@cache_answers(64)
def load_kernel(kernel: MarchKernel) -> Any:
    """Return the compiled library of a kernel."""
    library = load_library(_write_source(kernel), kernel.flags, soon=kernel.lanes == 1)
    for name in ("march_on", "size_of_block"):
        getattr(library, name).restype = ctypes.c_long
    library.time_of.restype = ctypes.c_double
    _LOADED.add(kernel)
    return library


def tell_readiness(kernel: MarchKernel) -> str:
    """Return `loaded`, `compiled` (not yet loaded in this process) or `new`."""
    if kernel in _LOADED:
        return "loaded"
    return "compiled" if is_compiled(_write_source(kernel), kernel.flags, soon=kernel.lanes == 1) else "new"


def _format_list(numbers: Sequence[float]) -> str:
    return "{" + ", ".join(map(repr, [*numbers, 0])) + "}"
