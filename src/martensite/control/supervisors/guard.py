"""Guard: a list of checks, and a safe signal for as long as one of them does not hold.

In every period all checks look at what is wanted and at the readings. The signals that a check
which trips speaks for are replaced by the safe one, in the same period. They come back

    never (`latch`):    not before the guard is put to rest again, as at the start of a run;
    later (`resume`):   when the check says that all is well, at the earliest after `hold`.

How far apart tripping and being well are is the `band` of a check. Of all checks that have cut, the one with the lowest
alarm is shown; the table of alarms is that of `martensite.control.checks.base`.
"""

from martensite.base.errors import ParameterError
from martensite.base.parameters import option, param, part
from martensite.control.checks.base import AbstractCheck, Checks
from martensite.control.checks.thermal_bound import ThermalBound
from martensite.control.loop.parts import SUPERVISORS, AbstractSupervisor, Column, Named, SupervisorVerdict
from martensite.kernels.namespace import Flag, Namespace, Scalar
from martensite.signals.base import DRIVE

OWN = 2
"""Numbers that the guard remembers of each check: whether it has cut, and for how long still."""


@SUPERVISORS.register("guard")
class Guard(AbstractSupervisor):
    """Cuts signals when a check does not hold."""

    checks: Checks = part(
        "what is checked, by names of one's own",
        default=Checks(),
        typical={"hot": {"kind": "overheat"}, "lost": {"kind": "sensor-lost"}},
    )
    answer: str = option("when signals come back", "latch", "resume", default="latch")
    hold: Scalar = param("s", "shortest time of a cut", low=0.0, default=0.0, typical="0.1 s")
    safe: Scalar = param(DRIVE, "signal of a cut", default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if the signal of a cut is not safe."""
        for name, one in self.checks.members().items():
            if isinstance(one, ThermalBound) and not one.holds(self.safe):
                raise ParameterError(
                    f"A guard cuts to a signal of {self.safe:g}, under which the bound of its "
                    f"check `{name}` still passes {one.limit:g} K; choose a smaller `safe`."
                )

    def reads(self) -> tuple[str, ...]:
        """What the checks read."""
        return tuple(name for one in self.checks.members().values() for name in one.reads())

    def drives(self) -> tuple[str, ...]:
        """Drives that the checks speak of."""
        return tuple(name for one in self.checks.members().values() for name in one.names())

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Nothing cut."""
        found: list[Scalar] = []
        for one in self.checks.members().values():
            found += [0.0, 0.0, *one.rest(xp, readings)]
        return tuple(found)

    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        """What all checks leave of the signals."""
        allowed, rows = dict(wanted), list[tuple[AbstractCheck, Flag, Scalar, Column]]()
        for one, own in self._pair_memories(memory):
            found = one.look(xp, own[OWN:], wanted, readings, dt)
            cut = self._decide_cut(xp, own, found.trips, found.clears)
            left = xp.where(found.trips, self.hold, xp.maximum(own[1] - dt, 0.0))
            rows.append((one, cut, left, found.memory))
            for name in one.cuts() or wanted:
                allowed[name] = xp.where(cut, self.safe, allowed[name])
        kept: list[Scalar] = []
        for one, cut, left, own in rows:
            kept += [xp.where(cut, 1.0, 0.0), left, *one.remember_allowed(xp, own, allowed, dt)]
        return SupervisorVerdict(allowed, _find_alarm(xp, [(one, cut) for one, cut, _, _ in rows]), tuple(kept))

    def _decide_cut(self, xp: Namespace, own: Column, trips: Flag, clears: Flag) -> Flag:
        before = own[0] > 0.5
        if self.answer == "latch":
            return xp.either(before, trips)
        stays = xp.either(xp.negate(clears), own[1] > 0.0)
        return xp.either(trips, xp.both(before, stays))

    def _pair_memories(self, memory: Column) -> list[tuple[AbstractCheck, Column]]:
        """Every check with its part of the memory."""
        found: list[tuple[AbstractCheck, Column]] = []
        for one in self.checks.members().values():
            size = OWN + one.size
            found.append((one, memory[:size]))
            memory = memory[size:]
        return found


def _find_alarm(xp: Namespace, rows: list[tuple[AbstractCheck, Flag]]) -> Scalar:
    """The lowest number of all checks that cut; 0 if none does."""
    alarm: Scalar = 0.0
    for one, cut in sorted(rows, key=lambda row: -row[0].alarm):
        alarm = xp.where(cut, float(one.alarm), alarm)
    return alarm
