"""ON/OFF control: full signal until a measured quantity reaches its target, then none.

    off if y(t - t_d) ≥ target,     on if y(t - t_d) < target - band,     else as before

y is any output of the system by its name, such as `alpha` of a platform or `temperature`. It is
sampled once in every period of the loop and arrives t_d late: the loop acts on the latest sample
that is at least t_d old, and before there is one on the first. With delay and sampling together,
what moves at the rate v overshoots by about v (t_d + one period).

A quantity that falls when the signal is on is controlled with `high` below `low`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from martensite.errors import ParameterError, suggestion
from martensite.parameters import param, part
from martensite.signals.base import DRIVE, AbstractDrive

HAIR = 1e-9
"""Difference of times that is rounding [s]."""


class Switch(NamedTuple):
    """What an ON/OFF controller remembers."""

    on: bool
    samples: tuple[tuple[float, float], ...]
    """Times [s] and values, from the one acted on to the latest."""


class OnOff(AbstractDrive):
    """A switch that keeps a measured quantity near its target."""

    measured: str = part("name of the output that is measured")
    target: float = param("1", "value to reach, in the SI unit of that output")
    band: float = param(
        "1", "how far below the target it is switched on again, in the same unit",
        low=0.0, default=0.0,
    )  # fmt: skip
    delay: float = param("s", "age of a measurement when it arrives", low=0.0, default=0.0)
    high: float = param(DRIVE, "signal while it is on")
    low: float = param(DRIVE, "signal while it is off", default=0.0)

    def init(self) -> Switch:
        """Off, with nothing measured."""
        return Switch(False, ())

    def __call__(
        self, time: float, measurement: Mapping[str, float], memory: Switch
    ) -> tuple[float, Switch]:
        """Signal at `time` [s], in the unit of the source, and the new memory.

        Raises:
            ParameterError: the system has no such output.
        """
        if self.measured not in measurement:
            raise ParameterError(
                f"`OnOff` cannot measure `{self.measured}`: the system has no such output. "
                f"{suggestion(self.measured, measurement)}"
            )
        known = (*memory.samples, (time, measurement[self.measured]))
        samples = arrived(known, time - self.delay)
        value = samples[0][1]
        on = value < self.target - self.band or (memory.on and value < self.target)
        return (self.high if on else self.low), Switch(on, samples)


def arrived(
    samples: tuple[tuple[float, float], ...], until: float
) -> tuple[tuple[float, float], ...]:
    """Samples without those that are older than the latest taken up to a time [s]."""
    old = [k for k, (taken, _) in enumerate(samples) if taken <= until + HAIR]
    return samples[old[-1] :] if old else samples
