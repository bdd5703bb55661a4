"""Which runtime a run is made on: plain floats, C or JAX, or the one that is done first."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from martensite.base.errors import SolveError
from martensite.simulate.adaptive import AdaptiveMarch
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.fixed import FixedMarch
from martensite.simulate.marching import Marched, MarchPlan

Tell = Callable[[str, float], None]
"""Told what is being done, and which share of it is."""
PATIENCE = 0.5
"""CPU time [s] for which a run is tried on floats before a compiler is started."""
HASTE = 0.1
"""The same where everything is compiled already, but not loaded."""
NATIVE = "martensite.simulate.marching_native"
"""What is not imported, nor NumPy with it, for a run that is over soon."""
OFTEN = 0.1
"""Time [s] between two calls of what watches."""


@dataclass
class RunEngine:
    """Makes runs of a system, on the runtime that was asked for."""

    compiled: CompiledMarch
    values: Sequence[float]
    runtime: str
    """`floats`, `c` or `auto`."""
    tell: Tell | None = None
    budget: float | None = None
    """CPU time [s] for all runs together."""
    used: str = "floats"
    """What the last run was made on."""
    begin: float = field(default_factory=time.process_time)

    def __call__(self, plan: MarchPlan) -> Marched:
        """Make a run.

        Raises:
            SolveError: the budget is spent.
        """
        if self.runtime == "auto":
            return self._quickest(plan)
        return self._on_c(plan) if self.runtime == "c" else self._on_floats(plan, hasty=False)

    def _quickest(self, plan: MarchPlan) -> Marched:
        """On floats if it is over soon, else in C, if there is a compiler."""
        from martensite.kernels.compiler import find_compiler

        if find_compiler() is None:
            return self._on_floats(plan, hasty=False)
        if self.used == "C" or (NATIVE in sys.modules and self._readiness(plan) == "loaded"):
            return self._on_c(plan)
        try:
            return self._on_floats(plan, hasty=True)
        except TimeoutError:
            return self._on_c(plan)

    def _readiness(self, plan: MarchPlan) -> str:
        """How near the runtime C is."""
        from martensite.simulate.marching_native import kernel_of, tell_readiness

        return tell_readiness(kernel_of(plan, range(len(self.compiled.outputs))))

    def _on_floats(self, plan: MarchPlan, hasty: bool) -> Marched:
        """A run on floats; `TimeoutError` if it is `hasty` and C would be done earlier."""
        self.used = "floats"
        functions = self.compiled.program.bind_floats(*self.values)
        march = FixedMarch if plan.step else AdaptiveMarch
        begin, watch = time.process_time(), self._watch("simulating")
        patience = HASTE if hasty else math.inf

        def look(share: float) -> None:
            nonlocal patience
            if time.process_time() - begin > patience:
                if patience == PATIENCE or self._readiness(plan) != "new":
                    raise TimeoutError
                patience = PATIENCE
            watch(share)

        return march(plan, functions).run(look)

    def _on_c(self, plan: MarchPlan) -> Marched:
        """A run in C, compiled if it has to be."""
        from martensite.simulate.marching_native import Runs, march_runs

        outputs = range(len(self.compiled.outputs))
        if self.tell is not None and self._readiness(plan) == "new":
            self.tell("compiling", 0.0)
        self.used = "C"
        runs = Runs(plan, self.values, 1, tuple(outputs), 1)
        return march_runs(runs, self._watch("simulating")).take_run(0, plan.times)

    def _watch(self, doing: str) -> Callable[[float], None]:
        """What looks at a run from time to time: at the budget, and for who wants to be told."""
        last = 0.0

        def watch(share: float) -> None:
            nonlocal last
            spent = time.process_time() - self.begin
            if self.budget is not None and spent > self.budget:
                raise SolveError(
                    f"The run was stopped, for its budget of {self.budget:.4g} s of CPU time was "
                    f"spent at {100.0 * share:.2g} % of it. Allow more, a larger tolerance, or a "
                    "shorter run."
                )
            if self.tell is not None and spent - last > OFTEN:
                last = spent
                self.tell(doing, share)

        return watch
