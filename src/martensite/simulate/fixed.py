"""The march on given steps, on plain floats: equal ones between samples and edges of the drives.

Nothing is estimated and nothing repeated; a step that crosses much of a transformation makes the
status LONG_STEP.
"""

from __future__ import annotations

import math

from martensite.signals.moments import Moments
from martensite.simulate.compiled import feed_step
from martensite.simulate.march import classify_step
from martensite.simulate.marching import HAIR, AbstractMarch


def pieces_of(length: float, step: float) -> int:
    """Into how many equal steps of at most `step` a length [s] is cut."""
    return max(1, math.ceil(length / step - HAIR))


class FixedMarch(AbstractMarch):
    """A run on steps of at most `Plan.step`."""

    def advance(self) -> None:
        """Go on to the next sample or edge."""
        plan = self.plan
        step = plan.step or plan.times[-1]
        begin, sample = self.time, plan.times[self.sample]
        hair = 1e-12 * self.duration
        edges = (e for r in self.readers for e in r.edges(begin + hair, sample - hair))
        end = min(edges, default=sample)
        count = pieces_of(end - begin, step)
        length = (end - begin) / count
        for k in range(count):
            here = begin + k * length
            self._step(here, length, end if k + 1 == count else here + length)
            if self.found.status.failed:
                return
        self.time = end
        if end == sample:
            signals = self.signals(sample)
            self.found.rows.append(self.functions["observe"](*self.state, *signals))
            self.sample += 1
        for reader in self.readers:
            reader.forget(end)

    def _step(self, begin: float, length: float, end: float) -> None:
        inputs = list[float]()
        for reader, width in zip(self.readers, self.plan.compiled.widths, strict=True):
            brought = reader.moments(begin, end) if width > 1 else reader.before(end)
            inputs += feed_step(brought) if isinstance(brought, Moments) else (brought,)
        after = self.functions["step"](*self.state, *inputs, length)
        residual, crossing, ripple = after[self.size :]
        found, self.state = self.found, after[: self.size]
        found.steps += 1
        found.longest, found.ripple = max(found.longest, length), max(found.ripple, ripple)
        found.residual = max(found.residual, residual)
        status = classify_step(residual, crossing)
        if status > found.status:
            found.status, found.time = status, begin
        self.time = begin
        self.see(self.functions["judge"](*self.state, *self.signals(end, before=True)))
