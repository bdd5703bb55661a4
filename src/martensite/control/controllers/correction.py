"""PID on top of a feed-forward signal, with the limits of both together.

    u = u_f + v,    low - u_f ≤ v ≤ high - u_f

where u_f is what the feed-forward says and v the answer of a PID law to what is still measured as an error. The
integral stops where the sum is at a limit. All gains are 0 to begin with: feed-forward alone.
"""

from __future__ import annotations

from martensite.base.parameters import Parametrised, param, part
from martensite.control.controllers.pid import Gains, PidLaw, PidMemory, sample_gains
from martensite.kernels.namespace import Namespace, Scalar

KEPT = len(PidMemory._fields)
"""Numbers that a correction remembers."""


class Correction(Parametrised):
    """Feedback beside a feed-forward, and the limits of the signal."""

    Kp: Scalar = param("1", "proportional gain, in signal per SI unit measured", default=0.0)
    Ki: Scalar = param("1/s", "integral gain", default=0.0)
    Kd: Scalar = param("s", "derivative gain, over the unit of the proportional one", default=0.0)
    law: PidLaw = part("limits of the whole signal, weights and filter", default=PidLaw())

    def limit_signal(self, xp: Namespace, signal: Scalar) -> Scalar:
        """A signal within the limits."""
        return xp.clip(signal, self.law.low, self.law.high)

    def rest(self, xp: Namespace, reference: Scalar, measured: Scalar) -> PidMemory:
        """Nothing integrated."""
        return self.law.rest(xp, reference, measured)

    def answer(
        self, xp: Namespace, memory: PidMemory, feed: Scalar, reference: Scalar, measured: Scalar, dt: Scalar
    ) -> tuple[Scalar, PidMemory]:
        """Signal of this sample with a feed-forward within the limits, and the new memory."""
        gains = sample_gains(xp, Gains(self.Kp, self.Ki, self.Kd), "in-seconds", dt)
        left = {"low": self.law.low - feed, "high": self.law.high - feed}
        added, after = self.law.rebuilt(left).answer(xp, gains, memory, reference, measured)
        return feed + added, after
