"""Names of drives, readings and outputs on a bench."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from martensite.actuators.assembly.base import DriveSignal
from martensite.actuators.mechanisms.base import Output
from martensite.control.controllers.base import AROUND
from martensite.control.loop.parts import MountedSensor
from martensite.control.observers.base import ESTIMATED

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench

MEASURED, REFERENCE, WANTED, NOISE, JITTER = "measured.", "reference", "wanted", "noise.", "jitter."
MANUAL, AUTOMATIC, SHAPED = "manual", "automatic", "shaped"
ALARM, CONTROLLER = "alarm", "controller"
AGE = ".age"
AMBIENT = "ambient"


def list_references(bench: Bench) -> list[str]:
    """Return the names of the references, in the order of the controllers."""
    names = list(bench.controllers.members())
    return [REFERENCE] if len(names) == 1 else [f"{REFERENCE}.{name}" for name in names]


class Preview(NamedTuple):
    """A reference ahead of time that a controller reads."""

    name: str
    """Drive of the bench, such as `reference.ahead.2`."""
    drive: str
    """Drive of the controller that follows the reference."""
    number: int
    time: float
    """Time ahead [s]."""


def list_previews(bench: Bench) -> list[Preview]:
    """Return the references ahead that controllers need, without repetition."""
    names = dict(zip(bench.controllers.members(), list_references(bench), strict=True))
    wanted = [item for one in bench.controllers.members().values() for item in one.list_previews().items()]
    return [
        Preview(f"{names[drive]}.ahead.{k}", drive, k, time)
        for drive, times in dict(wanted).items()
        for k, time in enumerate(times, 1)
    ]


def name_loop_columns(bench: Bench, drive: str) -> tuple[str, str, str]:
    """Return the columns of reference, wanted signal and reading of a controller."""
    members = bench.controllers.members()
    reference = list_references(bench)[list(members).index(drive)]
    measured = members[drive].measured
    reading = MEASURED + measured if measured in bench.sensors.members() else measured
    return reference, wanted_name(reference), reading


def outside_references(bench: Bench, outside: Iterable[str]) -> dict[str, str]:
    """Return the references of drives outside a bench, by drive: `reference` if single, else `reference.DRIVE`."""
    names = list(outside)
    alone = len(names) == 1 and not bench.controllers.members()
    return {name: REFERENCE if alone else f"{REFERENCE}.{name}" for name in names}


def describe_controllers(bench: Bench) -> dict[str, str]:
    """Describe controllers and their optional parts, by drive."""
    descriptions: dict[str, str] = {}
    for name, one in bench.controllers.members().items():
        around = ", ".join(part.replace("_", " ") for part in AROUND if one.__dict__[part] is not None)
        words = "; ".join(filter(None, (one.describe(bench.period), around and f"with {around}")))
        if words:
            descriptions[name] = f"`{one.registered_name}`: {words}"
    return descriptions


def list_hands(bench: Bench) -> dict[str, tuple[str, str]]:
    """Return the names of manual signal and mode, by drive of the controllers with a manual mode."""
    rows = zip(bench.controllers.members().items(), list_references(bench), strict=True)
    ends = {drive: name.removeprefix(REFERENCE) for (drive, one), name in rows if one.manual is not None}
    return {drive: (MANUAL + end, AUTOMATIC + end) for drive, end in ends.items()}


def list_drives(bench: Bench) -> list[DriveSignal]:
    """Return the references, references ahead, manual inputs, free drives of the plant, noise and jitter."""
    taken = bench.controllers.members()
    rows = zip(list_references(bench), reference_units(bench), strict=True)
    followed = [DriveSignal(name, unit, False, True) for name, unit in rows]
    units = dict(zip(taken, reference_units(bench), strict=True))
    followed += [DriveSignal(one.name, units[one.drive], False, True) for one in list_previews(bench)]
    free = [drive for drive in bench.plant.drives() if drive.name not in taken]
    numbers = [
        DriveSignal(kind + name, "1", False, True) for name in bench.sensors.members() for kind in (NOISE, JITTER)
    ]
    return [*followed, *hand_drives(bench), *free, *numbers]


def hand_drives(bench: Bench) -> list[DriveSignal]:
    """Return the signal and mode of every manual mode."""
    units = {drive.name: drive.unit for drive in bench.plant.drives()}
    rows = [(DriveSignal(u, units[drive], False, True), mode) for drive, (u, mode) in list_hands(bench).items()]
    return [one for signal, mode in rows for one in (signal, DriveSignal(mode, "1", False, True))]


def reference_units(bench: Bench) -> list[str]:
    """Return the SI units of the references, in the order of the controllers."""
    readings = {name: output.unit for name, output in list_readings(bench).items()}
    signals = {drive.name: drive.unit for drive in bench.plant.drives()}
    members = bench.controllers.members().items()
    return [one.reference_unit(readings, signals[name]) for name, one in members]


def list_readings(bench: Bench) -> dict[str, Output]:
    """Return the readings and estimates for controllers, and the ages of readings."""
    readings = {
        name: Output(_find_unit(bench, one), f"reading of {name}", f"y_{name}")
        for name, one in bench.sensors.members().items()
    }
    readings = readings or dict(bench.plant.outputs())
    ages = {name + AGE: Output("s", f"age of {name}", "t") for name in readings}
    return readings | list_estimates(bench) | ages


def list_estimates(bench: Bench) -> dict[str, Output]:
    """Return the estimates of the observers."""
    return {
        ESTIMATED + name: output._replace(long_name=f"estimated {output.long_name}")
        for one in bench.observers.members().values()
        for name, output in one.estimates().items()
    }


def list_outputs(bench: Bench) -> dict[str, Output]:
    """Return the outputs: plant, readings, estimates, references, wanted signals, controllers, and alarm."""
    readings = list_readings(bench)
    measured = {MEASURED + name: readings[name] for name in bench.sensors.members()}
    outputs = bench.plant.outputs() | measured | list_estimates(bench)
    signals = {drive.name: drive.unit for drive in bench.plant.drives()}
    members = bench.controllers.members().items()
    rows = zip(list_references(bench), reference_units(bench), members, strict=True)
    for name, unit, (drive, one) in rows:
        outputs[name] = reference_output(unit, one.measured or drive)
        outputs[wanted_name(name)] = wanted_output(signals[drive], drive)
    outputs |= list_shaped(bench)
    outputs |= list_controller_outputs(bench)
    if bench.supervisor is not None:
        outputs[ALARM] = Output("1", "alarm of the supervisor", "a")
    return outputs


def list_controller_outputs(bench: Bench) -> dict[str, Output]:
    """Return the outputs of controllers: `controller.NAME`, or `controller.DRIVE.NAME` for several."""
    return {
        name: output
        for drive in bench.controllers.members()
        for name, output in zip(
            name_controller_outputs(bench, drive).values(), _list_own(bench, drive).values(), strict=True
        )
    }


def name_controller_outputs(bench: Bench, drive: str) -> dict[str, str]:
    """Return the names of the outputs of a controller on a bench, by their names in the controller."""
    beside = f"{drive}." if len(bench.controllers.members()) > 1 else ""
    return {key: f"{CONTROLLER}.{beside}{key}" for key in _list_own(bench, drive)}


def _list_own(bench: Bench, drive: str) -> dict[str, Output]:
    members = bench.controllers.members()
    unit = reference_units(bench)[list(members).index(drive)]
    signal = next(one.unit for one in bench.plant.drives() if one.name == drive)
    return members[drive].list_outputs(unit, signal)


def list_shaped(bench: Bench) -> dict[str, Output]:
    """Return the shaped references: `shaped`, or `shaped.DRIVE` for several controllers."""
    members = bench.controllers.members().items()
    rows = zip(list_references(bench), reference_units(bench), members, strict=True)
    return {
        SHAPED + name.removeprefix(REFERENCE): Output(unit, f"shaped reference of {one.measured or drive}", "s")
        for name, unit, (drive, one) in rows
        if one.shaping is not None
    }


def reference_output(unit: str, followed: str) -> Output:
    """Return the output of a reference."""
    return Output(unit, f"reference of {followed}", "r")


def wanted_output(unit: str, drive: str) -> Output:
    """Return the output of the signal of a controller."""
    return Output(unit, f"signal that {drive} shall have", "u")


def wanted_name(reference: str) -> str:
    """Return the name of the wanted signal of a controller from its reference."""
    return WANTED + reference.removeprefix(REFERENCE)


def list_truths(bench: Bench) -> dict[str, Output]:
    """Return the outputs that sensors may measure: outputs of the plant, and the ambient temperature."""
    outputs = dict(bench.plant.outputs())
    for port in bench.plant.actuators():
        name = bench.plant.label(port, AMBIENT)
        outputs[name] = Output("K", "temperature of the surroundings", "T_a")
    return outputs


def _find_unit(bench: Bench, mounted: MountedSensor) -> str:
    if mounted.sensor.unit is not None:
        return mounted.sensor.unit
    return list_truths(bench)[mounted.sees()[0]].unit
