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
from martensite.boards.firmware.circuit import AMPLIFIER, HIGHEST_SUPPLY, Circuit, choose_divider, plan_circuit
from martensite.control.controllers.base import SignalLimits
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_readings
from martensite.control.loop.realtime import list_reads
from martensite.control.sensors.position import EncoderSensor
from martensite.control.sensors.resistance import ResistanceSensor
from martensite.kernels import floats
from martensite.physics.electrical.base import AbstractSwitch

LEAST = 0.05
"""Current over the largest below which a resistance is not measured."""
ROOM = 0.125
"""Margin of an analogue sensor at either end of the reference, over its span."""
FREQUENCY = 1000.0
"""Frequency of the pulses of a source without a frequency [Hz]."""
PULSES = 4.0
"""Least number of pulses in a sample, per measured wire: the firmware waits for at most two."""


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
    drive: int = -1
    """Drive in whose pulses the channel is read; -1 for a channel that no switch interrupts."""


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
    largest_current: float
    """Largest current at full signal over all resistances of the element [A]."""
    supply: float
    """[V]"""
    frequency: float
    """Frequency of the pulses [Hz]."""
    circuit: Circuit
    """Measurement of resistance, planned also for loops without it."""

    @property
    def measures_resistance(self) -> bool:
        """Return whether a reading is a resistance."""
        return any(one.ratio for one in self.readings)

    @property
    def least_duty(self) -> float:
        """Return the least duty cycle at which resistance is measured."""
        return self.circuit.pulse * self.frequency

    def told_channels(self) -> list[Channel]:
        """Return the channels that are no direct readings."""
        direct = {one.channel for one in self.readings if not one.ratio}
        return [one for k, one in enumerate(self.channels) if k not in direct]


def find_supply(bench: Bench) -> tuple[float, tuple[float, float]]:
    """Return the supply voltage [V], and the lowest and highest current of a closed switch [A].

    Raises:
        InputError: a source takes no duty cycle, or the supply is not an extra-low voltage.
    """
    volts, currents = 0.0, list[float]()
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
            currents.append(float(source.closed_current(floats, element.ohms(floats, fraction, 0.0, cold, 0.0))))
    if volts > HIGHEST_SUPPLY:
        raise InputError(
            f"The wiring is for extra-low voltage, at most {HIGHEST_SUPPLY:g} V, but `supply` is {volts:g} V: use an "
            "isolated power supply."
        )
    return volts, (min(currents), max(currents))


def find_frequency(bench: Bench, board: Board) -> float:
    """Return the frequency of the pulses [Hz].

    Raises:
        InputError: the timer of the board cannot do it, or a sample has too few pulses.
    """
    frequencies = {float(getattr(one.source, "frequency", FREQUENCY)) for one in bench.plant.actuators().values()}
    sensors = [one.sensor for name, one in bench.sensors.members().items() if name in list_reads(bench)]
    wires = sum(isinstance(one, ResistanceSensor) for one in sensors)
    least, most = max(board.pwm[0], max(PULSES * wires, 1.0) / bench.period), board.pwm[1]
    if len(frequencies) > 1:
        raise InputError(f"One timer switches all drives of {board.title}: write one `frequency` for all drivers.")
    (frequency,) = frequencies
    if not least <= frequency <= most:
        raise InputError(
            f"`driver.frequency` is {frequency:g} Hz, but {board.title} switches at {least:g} to {most:g} Hz with "
            f"samples of {1e3 * bench.period:g} ms: write a frequency in this range."
        )
    return frequency


def check_pulses(bench: Bench, board: Board, inputs: BoardInputs) -> None:
    """Raise `InputError` if the least signals of a loop give no readings of its resistance."""
    if not inputs.measures_resistance:
        return
    if board.hold == 0.0:
        raise InputError(
            f"{board.title} cannot convert within a pulse, so it measures no resistance: use another board."
        )
    laws = [part for one in bench.controllers.members().values() for part in (one, getattr(one, "law", None))]
    lows = [float(one.low) for one in laws if isinstance(one, SignalLimits)]
    probes = [getattr(one, "calibration", None) for one in bench.observers.members().values()]
    lows += [float(getattr(one, "probe", 0.0)) for one in probes]
    low = min((one for one in lows if one > 0.0), default=1.0)
    if low < inputs.least_duty:
        raise InputError(
            f"The loop measures with a duty cycle of {low:g}, pulses of {1e6 * low / inputs.frequency:.3g} us, but "
            f"{board.title} needs {1e6 * inputs.circuit.pulse:.3g} us: write a `driver.frequency` of at most "
            f"{low / inputs.circuit.pulse:.0f} Hz."
        )


def plan_inputs(bench: Bench, board: Board) -> BoardInputs:
    """Return channels and readings of a loop on a board.

    Raises:
        InputError: a source takes no duty cycle, a reading cannot be measured, or there are too few pins.
    """
    volts, currents = find_supply(bench)
    frequency, circuit = find_frequency(bench, board), plan_circuit(board, volts, currents)
    drives = [one.name for one in bench.plant.drives()]
    outputs, mounted = list_readings(bench), bench.sensors.members()
    channels, readings = list[Channel](), list[BoardReading]()
    pins, encoders = list(board.channel_pins), list(board.encoder_pins)

    def add_channel(name: str, unit: str, gain: float, offset: float, parts: str, drive: int = -1) -> int:
        if not pins:
            raise InputError(f"{board.title} has {len(board.channel_pins)} analogue inputs, which are not enough.")
        channels.append(Channel(name, unit, gain, offset, pins.pop(0), parts, drive))
        return len(channels) - 1

    for name in list_reads(bench):
        if name not in mounted:
            raise InputError(
                f"The loop reads `{name}`, for which the scenario has no sensor: a board measures nothing else."
            )
        sensor, unit = mounted[name].sensor, outputs[name].unit
        if isinstance(sensor, ResistanceSensor):
            step, (volt_name, amp_name) = board.volts / board.steps, mounted[name].sees()
            drive = drives.index(bench.plant.drive_at(find_port(bench, name)))
            words = f"difference amplifier {circuit.ratio:g} : 1, Kelvin leads at the ends of the wire"
            voltage = add_channel(volt_name, "V", circuit.ratio * step, 0.0, words, drive)
            words = f"amplifier x {AMPLIFIER:g}, Kelvin leads at a shunt of {circuit.shunt:g} ohm"
            current = add_channel(amp_name, "A", step / (circuit.shunt * AMPLIFIER), 0.0, words, drive)
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
        ratio = choose_divider(volts, board)
        gain = ratio * board.volts / board.steps
        supply = add_channel("supply.voltage", "V", gain, 0.0, f"divider {ratio:g} : 1 across the supply")
    inputs = BoardInputs(tuple(channels), tuple(readings), supply, currents[1], volts, frequency, circuit)
    check_pulses(bench, board, inputs)
    return inputs


def find_port(bench: Bench, name: str) -> str:
    """Return the port of the element whose resistance a sensor measures."""
    voltage = bench.sensors.members()[name].sees()[0]
    return next(port for port in bench.plant.actuators() if bench.plant.label(port, "voltage") == voltage)


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
