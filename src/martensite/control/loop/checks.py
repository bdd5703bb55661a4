"""What fits together on a bench, in sentences where it does not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.controllers.base import require_readings
from martensite.control.loop.names import list_readings as known_readings
from martensite.control.loop.names import list_truths
from martensite.physics.electrical.base import AbstractSwitch

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench


def check_bench(bench: Bench) -> None:
    """Raise `ParameterError` for the first name of a bench that is not known where it is used."""
    known, drives = list_truths(bench), [drive.name for drive in bench.plant.drives()]
    for name, mounted in bench.sensors.members().items():
        for seen in mounted.sees():
            if seen not in known:
                raise ParameterError(
                    f"Sensor `{name}` looks at `{seen}`, which the plant does not have. {suggest_name(seen, known)}"
                )
    for name in bench.controllers.members():
        if name not in drives:
            raise ParameterError(f"There is no drive `{name}`. {suggest_name(name, drives)}")
    _check_readings(bench)
    _check_faults(bench, drives)
    _check_switching(bench)


def _check_readings(bench: Bench) -> None:
    """What observers, controllers and supervisor read must exist."""
    readings = known_readings(bench)
    _check_estimates(bench)
    for name, observer in bench.observers.members().items():
        _require_names(f"Observer `{name}`", observer.reads(), readings)
    for controller in bench.controllers.members().values():
        require_readings(controller, readings)
        if not controller.kernel:
            raise ParameterError(
                f"Controller `{controller.registered_name}` is no kernel: run it as a drive of a "
                f"bench without controllers."
            )
    if bench.supervisor is not None:
        _require_names("The supervisor", bench.supervisor.reads(), readings)
        drives = [drive.name for drive in bench.plant.drives()]
        for name in bench.supervisor.drives():
            if name not in drives:
                raise ParameterError(
                    f"The supervisor speaks of drive `{name}`, which the plant does not have. "
                    f"{suggest_name(name, drives)}"
                )


def _check_estimates(bench: Bench) -> None:
    """Every estimate comes from one observer."""
    found: dict[str, str] = {}
    for title, observer in bench.observers.members().items():
        for name in observer.estimates():
            if name in found:
                raise ParameterError(
                    f"Observers `{found[name]}` and `{title}` both estimate `{name}`; a bench has "
                    f"one estimate of a name."
                )
            found[name] = title


def _require_names(who: str, names: tuple[str, ...], readings: Mapping[str, object]) -> None:
    for name in names:
        if name not in readings:
            raise ParameterError(f"{who} reads `{name}`, which is not measured. {suggest_name(name, readings)}")


def _check_faults(bench: Bench, drives: list[str]) -> None:
    """What faults disturb must exist."""
    known = {"sensor": list(bench.sensors.members()), "drive": drives}
    for title, fault in bench.faults.members().items():
        for name, what in fault.names().items():
            if name not in known[what]:
                raise ParameterError(f"Fault `{title}`: there is no {what} `{name}`. {suggest_name(name, known[what])}")


def _check_switching(bench: Bench) -> None:
    """Pulses are for one switch."""
    sources = [one.source for one in bench.plant.actuators().values()]
    one = len(bench.plant.drives()) == 1 and len(sources) == 1
    duty = one and isinstance(sources[0], AbstractSwitch) and sources[0].unit == "1"
    if bench.switching == "pulses" and not duty:
        raise ParameterError(
            "Pulses are for a plant with one drive, a switch that takes a duty, such as `pwm-voltage`."
        )
