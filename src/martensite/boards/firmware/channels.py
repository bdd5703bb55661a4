"""Inputs of a board for a loop: raw channels, readings computed from them, and nominal gains.

The reading of a resistance is a voltage over a current; an encoder counts; other readings are voltages at the
converter. Nominal gains follow from the parts of the wiring list and suffice for trials only: a board arms on its
readings only after calibration.
"""

from __future__ import annotations

from dataclasses import dataclass

from martensite.actuators.elements.lumped import AbstractLumped
from martensite.base.errors import InputError
from martensite.boards.firmware.boards import Board
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_readings
from martensite.control.loop.realtime import list_reads
from martensite.control.sensors.position import EncoderSensor
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.kernels import floats
from martensite.physics.electrical.base import AbstractSwitch

SHUNT, AMPLIFIER = 0.1, 20.0
"""Assumed shunt [ohm] and gain of the current amplifier."""
DIVIDERS = (1.0, 2.0, 3.0, 5.0, 11.0)
"""Ratios of dividers of common resistors: none, 10k:10k, 20k:10k, 40k:10k, 100k:10k."""
LEAST = 0.05
"""Current over the largest below which a resistance is not measured."""
ROOM = 0.125
"""Margin of an analogue sensor at either end of the reference, over its span."""
MARGIN = 1.25
"""Current over the largest expected one at which the board disarms."""


@dataclass(frozen=True)
class Channel:
    """One raw number of a board."""

    name: str
    unit: str
    gain: float
    offset: float
    """Steps at a value of 0."""
    pin: int
    parts: str
    """Parts between the quantity and the pin, in words."""


@dataclass(frozen=True)
class BoardReading:
    """A reading of a loop."""

    name: str
    unit: str
    channel: int
    other: int
    """Channel of the current for a resistance; else the same channel."""
    ratio: bool


@dataclass(frozen=True)
class BoardInputs:
    """All measurements of a board."""

    channels: tuple[Channel, ...]
    readings: tuple[BoardReading, ...]
    supply_channel: int
    """Channel of the supply voltage; -1 without a free pin."""
    current_channel: int
    """Channel of the current of the only wire; -1 if not measured."""
    largest_current: float
    """Largest current at full signal over all resistances of the element [A]."""
    supply: float
    """[V]"""

    def told_channels(self) -> list[Channel]:
        """Return the channels that are no direct readings."""
        direct = {one.channel for one in self.readings if not one.ratio}
        return [one for k, one in enumerate(self.channels) if k not in direct]


def find_supply(bench: Bench) -> tuple[float, float]:
    """Return the supply voltage [V], and the largest current at full signal [A].

    Raises:
        InputError: a source takes no duty cycle.
    """
    volts, most = 0.0, 0.0
    for one in bench.plant.actuators().values():
        source, element = one.source, one.element
        if not isinstance(source, AbstractSwitch) or source.unit != "1":
            raise InputError(
                f"A board closes a switch, but driver `{source.registered_name}` takes a signal in {source.unit}: "
                "write `mosfet` or `pwm-voltage`."
            )
        volts = max(volts, float(source.supply))
        cold = one.environment.temperature
        if not isinstance(element, AbstractLumped):
            raise InputError("A board drives an element of one temperature, such as a wire or a coil.")
        for fraction in (0.0, 1.0):
            most = max(most, abs(source.current(floats, 1.0, element.ohms(floats, fraction, 0.0, cold, 0.0))))
    return volts, most


def plan_inputs(bench: Bench, board: Board) -> BoardInputs:
    """Return channels and readings of a loop on a board.

    Raises:
        InputError: a source takes no duty cycle, a reading cannot be measured, or there are too few pins.
    """
    volts, most = find_supply(bench)
    outputs, mounted = list_readings(bench), bench.sensors.members()
    channels, readings = list[Channel](), list[BoardReading]()
    pins, encoders, current = list(board.channel_pins), list(board.encoder_pins), -1

    def add_channel(name: str, unit: str, gain: float, offset: float, parts: str) -> int:
        if not pins:
            raise InputError(f"{board.title} has {len(board.channel_pins)} analogue inputs, which are not enough.")
        channels.append(Channel(name, unit, gain, offset, pins.pop(0), parts))
        return len(channels) - 1

    for name in list_reads(bench):
        if name not in mounted:
            raise InputError(
                f"The loop reads `{name}`, for which the scenario has no sensor: a board measures nothing else."
            )
        sensor, unit = mounted[name].sensor, outputs[name].unit
        if isinstance(sensor, ResistanceSensor):
            ratio, gain = choose_divider(volts, board)
            end = "" if name == "resistance" else f"_{name.removeprefix('resistance_')}"
            voltage = add_channel(f"voltage{end}", "V", gain, 0.0, f"divider {ratio:g} : 1 across the wire")
            amps = board.volts / board.steps / (SHUNT * AMPLIFIER)
            words = f"shunt of {SHUNT:g} ohm in series, amplifier x {AMPLIFIER:g}"
            current = add_channel(f"current{end}", "A", amps, 0.0, words)
            readings.append(BoardReading(name, unit, voltage, current, True))
        elif isinstance(sensor, EncoderSensor):
            if not encoders:
                raise InputError(f"{board.title} has no free pair of pins for the encoder of `{name}`.")
            channels.append(
                Channel(name, unit, float(sensor.resolution), 0.0, -1 - encoders.pop(0), "encoder, two lines")
            )
            readings.append(BoardReading(name, unit, len(channels) - 1, len(channels) - 1, False))
        else:
            span, low = _find_range(bench, name)
            gain = span / board.steps
            words = f"sensor whose full scale is {span:.3g} {unit} over {board.volts:g} V"
            place = add_channel(name, unit, gain, 0.0 - low / gain, words)
            readings.append(BoardReading(name, unit, place, place, False))
    supply = -1
    if pins:
        ratio, gain = choose_divider(volts, board)
        supply = add_channel("supply.voltage", "V", gain, 0.0, f"divider {ratio:g} : 1 across the supply")
    return BoardInputs(tuple(channels), tuple(readings), supply, current, most, volts)


def choose_divider(volts: float, board: Board) -> tuple[float, float]:
    """Return the ratio of a divider for a voltage [V], and volts per step.

    Raises:
        InputError: the voltage is too high.
    """
    for ratio in DIVIDERS:
        if volts <= ratio * board.volts:
            return ratio, ratio * board.volts / board.steps
    raise InputError(
        f"A supply of {volts:g} V is more than the wiring here measures: {DIVIDERS[-1] * board.volts:g} V."
    )


def _find_range(bench: Bench, name: str) -> tuple[float, float]:
    """Return full scale and least value of an analogue sensor, from its limits or from the reference."""
    limits = bench.sensors.members()[name].sensor.limits()
    if limits is not None:
        return float(limits[1] - limits[0]), float(limits[0])
    for one in bench.controllers.members().values():
        if one.measured == name:
            levels = [one.reference.value(0.01 * k) for k in range(10_001)]
            low, high = min(*levels, 0.0), max(levels)
            span = high - low or 1.0
            return (1.0 + 2.0 * ROOM) * span, low - ROOM * span
    return 400.0, 233.15  # sensors without a range that no loop controls are thermometers
