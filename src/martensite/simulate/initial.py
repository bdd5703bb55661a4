"""Initial state of a run: given coordinates, speeds, temperatures and phase states.

By default a system starts at home in equilibrium at ambient temperature and load. This assembly also defines the
lengths of the elements. The mechanism then moves to the given coordinates, and the elements take the given
temperatures and phase states. Forces follow from the element lengths, or from the load line for a mechanism without
coordinates. Other quantities remain as assembled. A phase state that the law leaves immediately is refused.

Alternatively, `martensite.simulate.settling` searches for the initial state.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, cast

from martensite.actuators.assembly import AbstractSystem, Actuator, State
from martensite.actuators.assembly.base import AbstractAssembly
from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base import units
from martensite.base.errors import InputError, suggest_name
from martensite.kernels import floats
from martensite.kernels.nested import flatten_numbers
from martensite.physics.laws.base import Fractions
from martensite.simulate.compiled import bind_march, compile_march
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms
from martensite.simulate.envelope import describe_exit, envelope_of
from martensite.simulate.restarts import AT, CYCLE, EQUILIBRIUM, HOME, PERIOD, WHERE, PassState, Restart

OF_ELEMENT = {"temperature": "K", "martensite_fraction": "1", "oriented_fraction": "1"}
"""Initial quantities of an element, with their units."""
FITS = 50
"""Maximum iterations between forces and elements."""
NUDGE, LOST = 0.01, 0.02
"""Temperature change [K] for a stability test, and the accepted change of a phase fraction."""


def list_initial(system: AbstractSystem) -> dict[str, str]:
    """Return the initial quantities of a system, with their units.

    Raises:
        InputError: the system has other parts than a mechanism and elements.
    """
    if not isinstance(system, AbstractAssembly):
        raise InputError(
            f"{WHERE} sets the start of a mechanism with elements; it has no effect on a bench or a model."
        )
    quantities = dict(system.mechanism.initial_numbers())
    for port in system.actuators():
        quantities |= {system.label(port, name): unit for name, unit in OF_ELEMENT.items()}
    return quantities


def read_initial(system: AbstractSystem, table: Mapping[str, Any], with_units: bool = False) -> dict[str, Any]:
    """Return a table [initial] in SI by full name; `with_units` refuses plain numbers.

    Raises:
        InputError: a name is unknown, a unit does not fit, or values conflict with a search.
    """
    choices, given = list_initial(system), dict[str, Any]()
    for name, value in table.items():
        rows = cast("Mapping[str, Any]", value).items() if isinstance(value, Mapping) else ()
        given |= {f"{name}.{key}": one for key, one in rows} or {name: value}
    if AT in given:
        require_search(given)
        choices = {AT: "", PERIOD: "s"}
    for name in given:
        if name not in choices:
            raise InputError(f"{WHERE} has no `{name}`. {_suggest(system, name, [*choices, AT])}")
    return {name: one if name == AT else _convert(name, one, choices[name], with_units) for name, one in given.items()}


def require_search(given: Mapping[str, Any]) -> None:
    """Raise `InputError` unless a table only specifies a search."""
    if given[AT] not in (EQUILIBRIUM, CYCLE):
        raise InputError(f"{WHERE} `at` is not known. {suggest_name(str(given[AT]), (EQUILIBRIUM, CYCLE))}")
    allowed = (AT, PERIOD) if given[AT] == CYCLE else (AT,)
    other = next((name for name in given if name not in allowed), None)
    if other is not None:
        raise InputError(f"{WHERE} has `at` and `{other}`; give either `at` or values.")


def _suggest(system: AbstractSystem, name: str, choices: Sequence[str]) -> str:
    """Return the nearest name; a port of a machine stands for all quantities of its element."""
    port, _, own = name.rpartition(".")
    ports = [one for one in system.actuators() if system.label(one, AT) != AT]
    return (
        suggest_name(own, OF_ELEMENT) if port in ports else suggest_name(name, {n.partition(".")[0] for n in choices})
    )


def _convert(name: str, value: Any, unit: str, with_units: bool) -> float:
    """Return a value in SI."""
    try:
        if isinstance(value, str):
            return units.parse_quantity(value, unit)
        plain = not with_units or unit == "1"
        if plain and isinstance(value, int | float) and math.isfinite(value):
            return float(value)
    except InputError as error:
        raise InputError(f"{WHERE} `{name}`: {error}") from None
    raise InputError(f'{WHERE} `{name}` must be a text with a unit, such as "1 {unit}", but is {value!r}.')


def find_start(
    system: AbstractSystem, waveform: Waveforms, initial: Mapping[str, Any], tolerance: float = 1e-4
) -> Restart:
    """Return the start of a run from the given quantities or by a search.

    Raises:
        InputError: the given quantities do not fit the system, or the state is impossible.
        SolveError: a search reached an impossible state.
    """
    given = read_initial(system, initial)
    if AT in given:
        from martensite.simulate.settling import find_settled

        return find_settled(system, waveform, given, tolerance)
    if not given or not isinstance(system, AbstractAssembly):
        return HOME
    first = [one.value(0.0) for one in arrange_waveforms(system, waveform)]
    state = tuple(map(float, flatten_numbers(place_system(system, given, first))))
    _check_envelope(system, state, first)
    return Restart(0.0, (PassState(state),))


def place_system(system: AbstractAssembly, given: Mapping[str, float], drives: Sequence[float]) -> State:
    """Return the state with given values in SI by full name, under drive signals.

    Raises:
        InputError: an element cannot be in that state.
    """
    home, mechanism, actuators = system.init(floats, *drives), system.mechanism, system.actuators()
    rows = list(zip(actuators.items(), drives, strict=False))
    names = {port: {name: system.label(port, name) for name in OF_ELEMENT} for port in actuators}
    owns = [{name: given[full] for name, full in names[port].items() if full in given} for port in actuators]
    own_signals = system.mechanism_signals(drives)
    elements, memory, forces = list(home.elements), home.mechanism, [float("nan")] * len(rows)
    for _ in range(FITS):
        loads = [one.load(state, drive) for ((_, one), drive), state in zip(rows, elements, strict=True)]
        before = forces
        try:
            memory, forces = mechanism.set_initial(home.mechanism, given, loads, own_signals)
        except (InputError, ArithmeticError) as error:
            raise InputError(f"{WHERE} {error}") from None
        elements = [
            _put_element(port, one, own, drive, state, force)
            for ((port, one), drive), own, state, force in zip(rows, owns, home.elements, forces, strict=True)
        ]
        if all(abs(a - b) <= 1e-12 * abs(a) for a, b in zip(forces, before, strict=True)):
            break
    else:
        raise InputError(f"{WHERE} No forces balance the elements and the mechanism in that state.")
    for ((port, one), _), state in zip(rows, elements, strict=True):
        _check_phases(system, port, one, state)
    return State(tuple(elements), memory)


def _put_element(port: str, one: Actuator, own: Mapping[str, float], drive: float, home: Any, force: float) -> Any:
    """Return an element with its given temperature and phase state, under a drive signal and a force [N]."""
    element, imposed = one.element, one.source.sets_temperature
    if imposed and "temperature" in own:
        raise InputError(f"{WHERE} The temperature of `{port}` is prescribed by its drive; leave it out.")
    warm = own.get("temperature", drive if imposed else one.environment.temperature)
    phases = "martensite_fraction" in own or "oriented_fraction" in own
    if isinstance(element, AbstractLumped) and element.uniform:
        fractions = element.law.fractions(home.memory)
        return element.init_in(_find_fractions(port, element, own, fractions) if phases else fractions, force, warm)
    if phases:
        raise InputError(
            f"{WHERE} Element `{element.registered_name}` is not uniform, and has no single phase state. "
            "Use a uniform element, such as `wire`, or leave the fractions out."
        )
    return element.init(floats, force, warm)


def _find_fractions(port: str, element: AbstractLumped, own: Mapping[str, float], fractions: Fractions) -> Fractions:
    """Return the given phase state; other martensite keeps its orientation."""
    law, martensite = element.law, own.get("martensite_fraction", fractions.martensite)
    share = fractions.oriented / fractions.martensite if fractions.martensite else 1.0
    oriented = own.get("oriented_fraction", martensite * share)
    if not law.has_twins and oriented != martensite:
        raise InputError(
            f"{WHERE} Law `{law.registered_name}` knows oriented martensite only; leave `oriented_fraction` out."
        )
    low = 0.0 if law.tension_only else -martensite
    for name, value, least, most in (("martensite", martensite, 0.0, 1.0), ("oriented", oriented, low, martensite)):
        if not least <= value <= most:
            complaint = f"must be {least:.6g} to {most:.6g}, but is {value:.6g}"
            raise InputError(f"{WHERE} `{name}_fraction` of `{port}` {complaint}.")
    return Fractions(martensite, oriented)


def _check_phases(system: AbstractSystem, port: str, actuator: Actuator, state: Any) -> None:
    """Raise `InputError` for a phase state that the law leaves after any small change."""
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
                f"Give `{system.label(port, 'martensite_fraction')}`, or another temperature or place."
            )


def _check_envelope(system: AbstractSystem, state: tuple[float, ...], drives: Sequence[float]) -> None:
    """Raise `InputError` for a state outside the envelope."""
    judged_outputs = bind_march(system)[0]["judge"](*state, *drives)
    crossing = envelope_of(system).find_exit(judged_outputs[len(compile_march(system).convergence_scales) :])
    if crossing is not None:
        what = describe_exit(system, 0.0, *crossing).partition(": ")[2].replace(" came to ", " is ")
        raise InputError(f"{WHERE} No run starts there: {what}")
