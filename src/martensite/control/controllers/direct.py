"""No feedback: the reference, scaled, is the signal.

    u = K r + u_0

For tests of a plant, for records to identify from, and as what a controller with feedback is
compared with. The reference has the unit of the signal; limits are those of the source.
"""

from __future__ import annotations

from collections.abc import Mapping

from martensite.base.parameters import param, text
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE


@CONTROLLERS.register("direct")
class Direct(AbstractController):
    """A straight line from the reference to the signal."""

    measured: str = text("name of a reading to compare with; it is not read", default="")
    gain: Scalar = param("1", "signal per reference", default=1.0)
    offset: Scalar = param(DRIVE, "signal without a reference", default=0.0)

    def reads(self) -> tuple[str, ...]:
        """Nothing."""
        return ()

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        """That of the signal."""
        return signal

    def answer(
        self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar
    ) -> tuple[Scalar, Column]:
        """The signal of this sample."""
        return self.gain * reference + self.offset, ()
