"""Guard: a list of checks, and a safe signal for as long as one of them does not hold.

In every period all checks see the wanted signals and the readings. If a check trips, the safe signal replaces its
signals in the same period. They come back

    never (`latch`):    not before the guard is put to rest again, as at the start of a run;
    later (`resume`):   when the check says that all is well, at the earliest after `hold`;
    lowered (`limit`):  by a check that knows the largest signal with which it holds, such as a bound on the
                        temperature, signals are not cut but kept below that; the other checks latch.

The `band` of a check is the distance between tripping and clearing. Of all checks that have cut, the lowest alarm is
shown; the table of alarms is that of `martensite.control.checks.base`.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param, part
from martensite.control.checks.base import LIMITED, AbstractCheck, Checks
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.loop.parts import SUPERVISORS, AbstractSupervisor, Column, Named, SupervisorVerdict
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.signals.base import DRIVE

OWN = 2
"""Numbers that the guard remembers of each check: whether it has cut, and for how long still."""


class JudgedCheck(NamedTuple):
    """Result of a check in one sample."""

    check: AbstractCheck
    cut: Flag | None
    """True if the check cuts; None for a check that never cuts."""
    lowers: Flag | None
    """True if the check limits; None for a check that never limits."""
    left: Scalar
    """Time for which it still cuts [s]."""
    memory: Column


@SUPERVISORS.register("guard")
class Guard(AbstractSupervisor):
    """Cuts signals when a check does not hold."""

    checks: Checks = part(
        "what is checked, by names of one's own",
        default=Checks(),
        typical={"hot": {"kind": "overheat"}, "lost": {"kind": "sensor-lost"}},
    )
    answer: str = option("when signals come back", "latch", "resume", "limit", default="latch")
    hold: Number = param("s", "shortest time of a cut", low=0.0, default=0.0, typical="0.1 s")
    safe: Number = param(DRIVE, "signal of a cut", default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if it checks nothing, or the signal of a cut is not safe."""
        if not self.checks.members():
            raise ParameterError(
                "A guard without checks guards nothing; give it one, or in a scenario `from_plant = true`."
            )
        for name, one in self.checks.members().items():
            if isinstance(one, ThermalBound) and not one.holds(self.safe):
                raise ParameterError(
                    f"A guard cuts to a signal of {self.safe:g}, under which the bound of its "
                    f"check `{name}` still passes {one.limit:g} K; choose a smaller `safe`."
                )

    def reads(self) -> tuple[str, ...]:
        """Return the readings of the checks."""
        return tuple(name for one in self.checks.members().values() for name in one.reads())

    def drives(self) -> tuple[str, ...]:
        """Return the drives that the checks speak of."""
        return tuple(name for one in self.checks.members().values() for name in one.names())

    def name_checks(self) -> dict[int, list[str]]:
        """Return the number of an alarm -> names of the checks that raise it."""
        found: dict[int, list[str]] = {}
        for name, one in self.checks.members().items():
            found.setdefault(one.alarm, []).append(name)
        return found

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Nothing cut."""
        found: list[Scalar] = []
        for one in self.checks.members().values():
            found += [0.0, 0.0, *one.rest(xp, readings)]
        return tuple(found)

    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        """Return the signals that all checks allow."""
        allowed, rows = dict(wanted), list[JudgedCheck]()
        for one, own in self._pair_memories(memory):
            found = one.look(xp, own[OWN:], wanted, readings, dt)
            most = one.find_most(xp, found.memory, dt) if self.answer == "limit" else {}
            lowers = found.trips if most else None
            cut = None if most else self._decide_cut(xp, own, found.trips, found.clears)
            left = xp.where(found.trips, self.hold, xp.maximum(own[1] - dt, 0.0))
            rows.append(JudgedCheck(one, cut, lowers, left, found.memory))
            for name, size in most.items():
                allowed[name] = _lower_signal(xp, allowed[name], size, self.safe)
            if cut is not None:
                allowed |= {name: xp.where(cut, self.safe, allowed[name]) for name in one.cuts() or wanted}
        kept: list[Scalar] = []
        for one, cut, _, left, own in rows:
            held = 0.0 if cut is None else xp.where(cut, 1.0, 0.0)
            kept += [held, left, *one.remember_allowed(xp, own, allowed, dt)]
        return SupervisorVerdict(allowed, _find_alarm(xp, rows), tuple(kept))

    def _decide_cut(self, xp: Namespace, own: Column, trips: Flag, clears: Flag) -> Flag:
        before = own[0] > 0.5
        if self.answer != "resume":
            return xp.either(before, trips)
        stays = xp.either(xp.negate(clears), own[1] > 0.0)
        return xp.either(trips, xp.both(before, stays))

    def _pair_memories(self, memory: Column) -> list[tuple[AbstractCheck, Column]]:
        """Return every check with its part of the memory."""
        found: list[tuple[AbstractCheck, Column]] = []
        for one in self.checks.members().values():
            size = OWN + one.size
            found.append((one, memory[:size]))
            memory = memory[size:]
        return found


def _lower_signal(xp: Namespace, signal: Scalar, size: Scalar, safe: Scalar) -> Scalar:
    """Return a signal of either sign, limited to a size; the safe signal for NaN."""
    lowered = xp.where(signal > 0.0, size, xp.where(signal < 0.0, -size, safe))
    return xp.where(xp.abs(signal) <= size, signal, lowered)


def _find_alarm(xp: Namespace, rows: Sequence[JudgedCheck]) -> Scalar:
    """Return the lowest number of all checks that cut; else of those that limit, beyond 100; else 0."""
    alarm: Scalar = 0.0
    ordered = sorted(rows, key=lambda row: -row.check.alarm)
    for row in ordered:
        alarm = alarm if row.lowers is None else xp.where(row.lowers, float(LIMITED + row.check.alarm), alarm)
    for row in ordered:
        alarm = alarm if row.cut is None else xp.where(row.cut, float(row.check.alarm), alarm)
    return alarm
