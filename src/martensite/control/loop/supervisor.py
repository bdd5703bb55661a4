"""The contract of a supervisor: the last word on every signal before it reaches a source.

It sees the signals that controllers (or waveforms) want and all readings with their ages, and
answers with the signals that are allowed and a number for its alarm, 0 if all is well.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar

SUPERVISORS: Registry[AbstractSupervisor] = Registry("supervisor", "martensite.control.supervisors", typical="guard")
Column: TypeAlias = Sequence[Scalar]
Named: TypeAlias = Mapping[str, Scalar]


class SupervisorVerdict(NamedTuple):
    """What a supervisor says."""

    signals: dict[str, Scalar]
    """Allowed, by the name of the drive."""
    alarm: Scalar
    """0, or the number of the alarm."""
    memory: Column


class AbstractSupervisor(Parametrised):
    """Interface of a supervisor."""

    def reads(self) -> tuple[str, ...]:
        """Names of the readings that it needs."""
        return ()

    def drives(self) -> tuple[str, ...]:
        """Names of the drives that it speaks of."""
        return ()

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """What it remembers before the first sample."""
        return ()

    @abstractmethod
    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        """What is allowed for the next period.

        Args:
            xp: namespace.
            memory: from the period before, or from `rest`.
            wanted: signals by the name of the drive.
            readings: by name, in SI, and the age of each, `NAME.age` [s].
            dt: length of the period [s].
        """
