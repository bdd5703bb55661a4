"""Guard: checks, and a safe signal while one of them does not hold.

In every period all checks see the wanted signals and the readings. If a check trips, the safe signal replaces the
signals in the same period. The answer determines when they come back:

    `latch`:   when the guard is reset, as at the start of a run;
    `resume`:  when the check clears, at the earliest after `hold`;
    `limit`:   a check that knows the largest allowed signal, such as a temperature bound, limits signals and does not
               cut them; the other checks latch.

The `band` of a check is the distance between tripping and clearing. The guard reports the lowest alarm of all checks
that have cut; `martensite.control.checks.base` has the table of alarms.
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
"""Values that the guard remembers of each check: whether it has cut, and the remaining time of the cut."""


class JudgedCheck(NamedTuple):
    """Result of a check in one sample."""

    check: AbstractCheck
    cut: Flag | None
    """True if the check cuts; None for a check that never cuts."""
    lowers: Flag | None
    """True if the check limits; None for a check that never limits."""
    remaining_time: Scalar
    """Remaining time of the cut [s]."""
    memory: Column


@SUPERVISORS.register("guard")
class Guard(AbstractSupervisor):
    """Cut signals if a check does not hold."""

    checks: Checks = part(
        "checks by user-defined names",
        default=Checks(),
        typical={"hot": {"kind": "overheat"}, "lost": {"kind": "sensor-lost"}},
    )
    answer: str = option("when signals come back", "latch", "resume", "limit", default="latch")
    hold: Number = param("s", "shortest time of a cut", low=0.0, default=0.0, typical="0.1 s")
    safe: Number = param(DRIVE, "signal of a cut", default=0.0)

    def check(self) -> None:
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
        return tuple(name for one in self.checks.members().values() for name in one.reads())

    def drives(self) -> tuple[str, ...]:
        return tuple(name for one in self.checks.members().values() for name in one.names())

    def name_checks(self) -> dict[int, list[str]]:
        names: dict[int, list[str]] = {}
        for name, one in self.checks.members().items():
            names.setdefault(one.alarm, []).append(name)
        return names

    def rest(self, xp: Namespace, readings: Named) -> Column:
        return tuple(x for one in self.checks.members().values() for x in (0.0, 0.0, *one.rest(xp, readings)))

    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        allowed, rows = dict(wanted), list[JudgedCheck]()
        for one, own in self._pair_memories(memory):
            look = one.look(xp, own[OWN:], wanted, readings, dt)
            most = one.find_most(xp, look.memory, dt) if self.answer == "limit" else {}
            lowers = look.trips if most else None
            cut = None if most else self._decide_cut(xp, own, look.trips, look.clears)
            left = xp.where(look.trips, self.hold, xp.maximum(own[1] - dt, 0.0))
            rows.append(JudgedCheck(one, cut, lowers, left, look.memory))
            for name, size in most.items():
                allowed[name] = _lower_signal(xp, allowed[name], size, self.safe)
            if cut is not None:
                allowed |= {name: xp.where(cut, self.safe, allowed[name]) for name in one.cuts() or wanted}
        memories: list[Scalar] = []
        for one, cut, _, left, own in rows:
            flag = 0.0 if cut is None else xp.where(cut, 1.0, 0.0)
            memories += [flag, left, *one.remember_allowed(xp, own, allowed, dt)]
        return SupervisorVerdict(allowed, _find_alarm(xp, rows), tuple(memories))

    def _decide_cut(self, xp: Namespace, own: Column, trips: Flag, clears: Flag) -> Flag:
        before = own[0] > 0.5
        if self.answer != "resume":
            return xp.either(before, trips)
        stays = xp.either(xp.negate(clears), own[1] > 0.0)
        return xp.either(trips, xp.both(before, stays))

    def _pair_memories(self, memory: Column) -> list[tuple[AbstractCheck, Column]]:
        pairs: list[tuple[AbstractCheck, Column]] = []
        for one in self.checks.members().values():
            size = OWN + one.size
            pairs.append((one, memory[:size]))
            memory = memory[size:]
        return pairs


def _lower_signal(xp: Namespace, signal: Scalar, size: Scalar, safe: Scalar) -> Scalar:
    """Return a signal of either sign, limited to a size; the safe signal for NaN."""
    lowered = xp.where(signal > 0.0, size, xp.where(signal < 0.0, -size, safe))
    return xp.where(xp.abs(signal) <= size, signal, lowered)


def _find_alarm(xp: Namespace, rows: Sequence[JudgedCheck]) -> Scalar:
    """Return the lowest alarm of the checks that cut; else of the checks that limit, plus 100; else 0."""
    alarm: Scalar = 0.0
    ordered = sorted(rows, key=lambda row: -row.check.alarm)
    for row in ordered:
        alarm = alarm if row.lowers is None else xp.where(row.lowers, float(LIMITED + row.check.alarm), alarm)
    for row in ordered:
        alarm = alarm if row.cut is None else xp.where(row.cut, float(row.check.alarm), alarm)
    return alarm
