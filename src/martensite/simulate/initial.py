"""Where a run starts: coordinates, speeds, temperatures and phase states that are given, or that are found by marching.

A system is assembled at home and at rest, as ever, which says how long its elements are there. Then its mechanism is
put where the given coordinates are, every element into the given temperature and phase state, and forces follow: of a
mechanism with coordinates from how long its elements are there, of a load line from what the element meets. What is
not given stays as assembled; a phase state that the law would leave at once is refused.

Or it is found: `equilibrium` is where the system comes to rest under the first values of its drives, `settled cycle`
where it begins a period of its drives that ends as it began. Both are marched to, with no guess of the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from martensite.actuators.assembly import Actuator, AbstractSystem, State
from martensite.actuators.assembly.base import AbstractAssembly
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base import units
from martensite.base.errors import InputError, suggest_name
from martensite.kernels import floats
from martensite.kernels.nested import flatten_numbers
from martensite.physics.laws.base import Fractions
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.api import longest_step, simulate
from martensite.simulate.compiled import bind_march, compile_march
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms, by_name
from martensite.simulate.envelope import describe_exit, envelope_of
from martensite.simulate.restarts import HOME, PassState, Restart
from martensite.simulate.result import Result

OF_ELEMENT = {"temperature": "K", "martensite_fraction": "1", "oriented_fraction": "1"}
"""What may be given of an element, with its unit."""
AT, PERIOD = "at", "period"
EQUILIBRIUM, CYCLE = "equilibrium", "settled cycle"
FITS = 50
"""Turns in which forces and elements are fitted."""
NUDGE, LOST = 0.01, 0.02
"""Change of temperature [K], and by how much of a fraction a phase state that lasts may answer to it."""
MOST_CYCLES, MOST_RESTS = 300, 9
"""Periods that are marched, and stretches of time, each twice as long as the one before."""
RESTLESS = 4
"""Stretches after which what moves must have come to less than half of what it was."""
REST = 200.0
"""The first of these, in steps with which a run begins."""
LOOKED = 65
"""Samples of such a run."""
WHERE = "[initial]"

Numbers = Mapping[str, float | str]
"""Name -> SI number or text, of an element of several as `port.temperature`, or as table by port."""


def list_initial(system: AbstractSystem) -> dict[str, str]:
    """What may be given of where a system starts, with its units.

    Raises:
        InputError: it has other parts than a mechanism and elements.
    """
    if not isinstance(system, AbstractAssembly):
        raise InputError(
            f"{WHERE} says where a mechanism with elements starts; it has no effect on a bench or a model."
        )
    found = dict(system.mechanism.initial_numbers())
    for port in system.actuators():
        found |= {_label(system, port, name): unit for name, unit in OF_ELEMENT.items()}
    return found


def read_initial(system: AbstractSystem, table: Mapping[str, Any]) -> dict[str, Any]:
    """A table [initial], in SI by full name.

    Raises:
        InputError: a name is not known, a unit does not fit, or numbers are given of what is to be found.
    """
    known, found, flat = list_initial(system), dict[str, Any](), dict[str, Any]()
    for name, value in table.items():
        flat |= {f"{name}.{key}": one for key, one in value.items()} if isinstance(value, Mapping) else {name: value}
    if AT in flat:
        return _read_search(flat)
    for name, value in flat.items():
        if name not in known:
            port, _, own = name.rpartition(".")
            several = [one for one in system.actuators() if _label(system, one, AT) != AT]
            valid = OF_ELEMENT if port in several else {n.partition(".")[0]: "" for n in [*known, AT]}
            raise InputError(f"{WHERE} has no `{name}`. {suggest_name(own if port in several else name, valid)}")
        try:
            found[name] = units.parse_quantity(value, known[name]) if isinstance(value, str) else float(value)
        except InputError as error:
            raise InputError(f"{WHERE} `{name}`: {error}") from None
    return found


def _read_search(table: Mapping[str, Any]) -> dict[str, Any]:
    """What is to be found, and after which period [s]."""
    others = [name for name in table if name != AT and (name != PERIOD or table[AT] != CYCLE)]
    if others:
        raise InputError(f"{WHERE} has `{others[0]}` beside `at`; give numbers, or what is to be found, not both.")
    if table[AT] not in (EQUILIBRIUM, CYCLE):
        raise InputError(f"{WHERE} `at` is not known. {suggest_name(str(table[AT]), (EQUILIBRIUM, CYCLE))}")
    period = table.get(PERIOD)
    return {AT: table[AT]} | ({PERIOD: _seconds(period)} if period is not None else {})


def _seconds(value: float | str) -> float:
    found = units.parse_quantity(value, "s") if isinstance(value, str) else float(value)
    if not found > 0.0:
        raise InputError(f"{WHERE} `period` must be above 0 s, but is {found:.6g} s.")
    return found


def find_start(system: AbstractSystem, waveform: Waveforms, initial: Numbers, tolerance: float = 1e-4) -> Restart:
    """Where a run starts, from what is given of it, or said to be found.

    Raises:
        InputError: what is given does not fit the system, or it cannot be in that state.
        SolveError: a search marched to where no run goes.
    """
    given = read_initial(system, initial)
    if not given:
        return HOME
    search = _Search(system, waveform, tolerance)
    if given.get(AT) == EQUILIBRIUM:
        return search.find_equilibrium()
    if given.get(AT) == CYCLE:
        return search.find_cycle(given.get(PERIOD))
    first = [one.value(0.0) for one in arrange_waveforms(system, waveform)]
    state = tuple(map(float, flatten_numbers(place_system(cast("AbstractAssembly", system), given, first))))
    _check_envelope(system, state, first)
    return Restart(0.0, (PassState(state),))


# ---------------------------------------------------------------- given numbers


def place_system(system: AbstractAssembly, given: Mapping[str, float], drives: list[float]) -> State:
    """The state with given numbers in SI by full name, under drive signals.

    Raises:
        InputError: an element cannot be in that state.
    """
    home, mechanism = system.init(floats, *drives), system.mechanism
    actuators = system.actuators()
    rows = list(zip(actuators.items(), drives, strict=False))
    elements, memory, forces = list(home.elements), home.mechanism, [float("nan")] * len(rows)
    for _ in range(FITS):
        loads = [one.load(state, drive) for ((_, one), drive), state in zip(rows, elements, strict=True)]
        before = forces
        try:
            memory, forces = mechanism.put(floats, home.mechanism, given, loads, drives[len(actuators) :])
        except (InputError, ArithmeticError) as error:
            raise InputError(f"{WHERE} {error}") from None
        elements = [
            _put_element(_Port(system, port, one, drive), given, state, force)
            for ((port, one), drive), state, force in zip(rows, home.elements, forces, strict=True)
        ]
        if all(abs(a - b) <= 1e-13 * abs(a) for a, b in zip(forces, before, strict=True)):
            break
    else:
        raise InputError(f"{WHERE} There are no forces at which the elements and the mechanism fit in that state.")
    for ((port, one), _), state in zip(rows, elements, strict=True):
        _check_phases(system, port, one, state)
    return State(tuple(elements), memory)


@dataclass(frozen=True)
class _Port:
    """An actuator where it stands."""

    system: AbstractSystem
    port: str
    actuator: Actuator
    drive: float

    def find(self, given: Mapping[str, float], name: str) -> float | None:
        """A given number of the element."""
        return given.get(_label(self.system, self.port, name))


def _put_element(where: _Port, given: Mapping[str, float], home: Any, force: float) -> Any:
    """An element in its given temperature and phase state, under a force [N]."""
    one, temperature = where.actuator, where.find(given, "temperature")
    element = one.element
    if one.source.sets_temperature and temperature is not None:
        raise InputError(f"{WHERE} The temperature of `{where.port}` is prescribed by its drive; leave it out.")
    warm = where.drive if one.source.sets_temperature else one.environment.temperature
    warm = warm if temperature is None else temperature
    m, o = (where.find(given, name) for name in ("martensite_fraction", "oriented_fraction"))
    if not isinstance(element, AbstractLumped) or not element.uniform:
        if m is not None or o is not None:
            raise InputError(
                f"{WHERE} Element `{element.registered_name}` is not the same all over: its phase state cannot be "
                "given; take a lumped one, such as `wire`, or leave it out."
            )
        return element.init(floats, force, warm)
    known = element.law.fractions(home.memory)
    martensite = known.martensite if m is None else m
    if o is None:
        o = martensite * (known.oriented / known.martensite if known.martensite else 1.0)
    if m is not None or where.find(given, "oriented_fraction") is not None:
        known = _check_fractions(where, element, martensite, o)
    return element.init_in(floats, known, force, warm)


def _check_fractions(where: _Port, element: AbstractLumped, martensite: float, oriented: float) -> Fractions:
    law = element.law
    if not 0.0 <= martensite <= 1.0:
        raise InputError(f"{WHERE} `martensite_fraction` of `{where.port}` must be 0 to 1, but is {martensite:.6g}.")
    if not law.twins and oriented != martensite:
        raise InputError(
            f"{WHERE} Law `{law.registered_name}` knows oriented martensite only; leave `oriented_fraction` out."
        )
    low = 0.0 if law.tension_only else -martensite
    if not low <= oriented <= martensite:
        raise InputError(
            f"{WHERE} `oriented_fraction` of `{where.port}` must be {low:.6g} to the martensite fraction, "
            f"{martensite:.6g}, but is {oriented:.6g}."
        )
    return Fractions(martensite, oriented)


def _check_phases(system: AbstractSystem, port: str, actuator: Actuator, state: Any) -> None:
    """Raise `InputError` for a phase state that the law leaves as soon as anything moves."""
    element = actuator.element
    if not isinstance(element, AbstractLumped) or not element.uniform or element.law.rate_dependent:
        return
    law, memory = element.apply_wear(floats, state.worn).law, state.memory
    now = law.fractions(memory)
    for by in (NUDGE, -NUDGE):
        after = law.kinetics(floats, memory, memory.stress, memory.temperature + by, 1.0)[1]
        if max(abs(a - b) for a, b in zip(after[:2], now[:2], strict=True)) > LOST:
            raise InputError(
                f"{WHERE} At {memory.temperature - 273.15:.5g} degC and {1e-6 * memory.stress:.4g} MPa law "
                f"`{law.registered_name}` does not keep a martensite fraction of {now.martensite:.4g} "
                f"({now.oriented:.4g} oriented) in `{port}`: it goes to {after.martensite:.4g} ({after.oriented:.4g}). "
                f"Give `{_label(system, port, 'martensite_fraction')}`, or another temperature or place."
            )


def _check_envelope(system: AbstractSystem, state: tuple[float, ...], drives: list[float]) -> None:
    """Raise `InputError` for a state in which no element can be."""
    seen = bind_march(system)[0]["judge"](*state, *drives)
    gone = envelope_of(system).find_exit(seen[len(compile_march(system).convergence_scales) :])
    if gone is not None:
        what = describe_exit(system, 0.0, *gone).partition(": ")[2].replace(" came to ", " is ")
        raise InputError(f"{WHERE} No run starts there: {what}")


def _label(system: AbstractSystem, port: str, name: str) -> str:
    return system.label(port, name)


# ---------------------------------------------------------------- states that are found


@dataclass(frozen=True)
class _Search:
    """Marches to where a run shall start."""

    system: AbstractSystem
    waveform: Waveforms
    tolerance: float

    def find_equilibrium(self) -> Restart:
        """Where nothing moves under the first values of the drives."""
        waves = by_name(self.system, self.waveform)
        held = {name: Constant(level=one.value(0.0)) for name, one in waves.items()}
        step = longest_step(self.system)
        length = REST * step if step < float("inf") else 1.0

        def rests(result: Result) -> float:
            half = len(result.times) // 2
            return self._worst(result, lambda column: max(column[half:]) - min(column[half:]), least_only=True)

        start, moved = HOME, [float("inf")]
        while len(moved) <= MOST_RESTS and not min(moved[:-RESTLESS], default=float("inf")) < 2.0 * min(
            moved[-RESTLESS:]
        ):
            start, by = self._march(held, length, start, rests)
            if by <= self.tolerance:
                return start
            moved.append(by)
            length *= 2.0
        raise InputError(
            f"{WHERE} The system does not come to rest under the first values of its drives: in the last "
            f"{0.25 * length:.4g} s what is judged still moved by {moved[-1]:.2g} times the least range that counts."
        )

    def find_cycle(self, period: float | None) -> Restart:
        """Where a period [s] begins that ends as it began."""
        waves = by_name(self.system, self.waveform)
        period = find_period(waves) if period is None else period
        for name, one in waves.items():
            require_periodic(name, one, period)

        def closes(result: Result) -> float:
            return self._worst(result, lambda column: abs(column[-1] - column[0]))

        start, open_by = HOME, float("inf")
        for _ in range(MOST_CYCLES):
            start, open_by = self._march(waves, period, start, closes)
            if open_by <= self.tolerance:
                return start
        raise InputError(
            f"{WHERE} The cycle of {period:.6g} s does not close: after {MOST_CYCLES} of them it still ends "
            f"{open_by:.2g} of a range from where it began, more than the tolerance of {self.tolerance:.2g}."
        )

    def _march(
        self, waves: Mapping[str, AbstractWaveform], length: float, start: Restart, judge: Callable[[Result], float]
    ) -> tuple[Restart, float]:
        """The state after a length of time [s], and what a judge says of the way there."""
        result = simulate(
            self.system, waves, length, tolerance=0.5 * self.tolerance, samples=LOOKED, start=start
        ).require()
        return result.restarts[-1].afresh(), judge(result)

    def _worst(self, result: Result, measure: Callable[[list[float]], float], least_only: bool = False) -> float:
        """Largest of what is measured of a judged column, as a share of its range, or of the least that counts."""
        found = [0.0]
        for name, least in self.system.convergence_scales().items():
            column = result.columns[name]
            found.append(measure(column) / (least if least_only else max(least, max(column) - min(column))))
        return max(found)


def find_period(waves: Mapping[str, AbstractWaveform]) -> float:
    """The period [s] of drives that have a `frequency`, all of them the same.

    Raises:
        InputError: they have none, or several.
    """
    moving = {name: one for name, one in waves.items() if not isinstance(one, Constant)}
    known = {getattr(one, "frequency", 0.0) for one in moving.values()}
    if len(known) != 1 or not min(known) > 0.0:
        raise InputError(
            f'{WHERE} The drives have no single `frequency`; give their `period`, such as `period = "2 s"`.'
        )
    return 1.0 / min(known)


def require_periodic(name: str, waveform: AbstractWaveform, period: float) -> None:
    """Raise `InputError` for a waveform that is another one a period [s] later."""
    places = [period * (k + 0.37) / LOOKED for k in range(LOOKED)]
    pairs = [(waveform.value(t), waveform.value(t + period)) for t in places]
    size = max(abs(a) for a, _ in pairs)
    for time, (a, b) in zip(places, pairs, strict=True):
        if abs(a - b) > 1e-6 * size:
            raise InputError(
                f"{WHERE} Drive `{name}` does not repeat after {period:.6g} s: it is {a:.6g} at {time:.6g} s, "
                f"but {b:.6g} a period later."
            )
