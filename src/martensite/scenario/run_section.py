"""Section [run] of a scenario: length, tolerance, samples, kept states and seed."""

from __future__ import annotations

import math

from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, param, text
from martensite.scenario.build import name_section


class Run(Parametrised):
    """Duration, tolerance and number of samples of a run."""

    duration: Number = param("s", "length of the run", above=0.0, default=math.inf)
    tolerance: Number = param(
        "1", "accepted change on halving the step, as a share of range", above=0.0, high=0.5, default=1e-4
    )
    samples: Number = param("1", "number of samples", low=2.0, high=1e7, default=1001)
    step: Number = param("s", "longest step; chosen by the tolerance if not given", above=0.0, default=math.inf)

    lead: Number = param(
        "s", "time before a log that is followed, to come from elsewhere to its beginning", low=0.0, default=0.0
    )

    restart: str | tuple[str, ...] = text("times at which a state is kept, to go on from with --from", default=())
    seed: Number = param("1", "seed of the noise of the sensors, a whole number", low=0.0, high=2**53, default=0)

    @override
    def check(self) -> None:
        for name in ("samples", "seed"):
            value = getattr(self, name)
            if value != int(value):
                raise ParameterError(f"Parameter `{name}` of `Run` must be a whole number, but is {value}.")

    def find_duration(self, end: float) -> float:
        """Return the duration, or the end of the signals [s] if none is given."""
        if math.isfinite(self.duration):
            return self.duration
        if not math.isfinite(end):
            raise ParameterError('[run] needs `duration`; write for example `duration = "60 s"`.')
        return end

    def list_restarts(self) -> tuple[float, ...]:
        """Return the times [s] at which a state is kept."""
        given = [self.restart] if isinstance(self.restart, str) else self.restart
        with name_section("run.restart"):
            return tuple(units.parse_quantity(one, "s") for one in given)
