"""Settings of a firmware, in flash or set by the host, and `settings.h` with both.

Limits and the parameters of the loop are constants in flash. The host sets calibration, references, free signals and
the gains that are declared tunable, each within its range; the board refuses everything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

from martensite.base.errors import InputError
from martensite.boards.firmware.alone import STARTS, StandAlone
from martensite.boards.firmware.boards import Board
from martensite.boards.firmware.bounds import NEAR, FirmwareBound
from martensite.boards.firmware.channels import LEAST, BoardInputs
from martensite.boards.firmware.circuit import MARGIN
from martensite.boards.firmware.ranges import Range, find_gain_range, find_offset_range
from martensite.boards.firmware.watchdog import choose_watchdog
from martensite.boards.link.messages import MOST

if TYPE_CHECKING:
    from martensite.export.c_core import CCore

TOLD = (MOST - 6) // 4
"""Largest number of values in a telemetry."""
MOST_TICKS = (1 << 31) - 1
"""Longest duration in ticks: a difference of two times of 32 bits that cannot be mistaken for a wrap."""
LOW_SUPPLY = 0.8
"""Supply voltage over the nominal one below which the board disarms."""


@dataclass(frozen=True)
class Setting:
    """One number of a firmware."""

    name: str
    unit: str
    value: float
    range: Range | None
    """Lowest and highest value that the host may set; None for a constant in flash."""
    about: str

    @property
    def fixed(self) -> bool:
        """Return whether the setting is a constant in flash."""
        return self.range is None


@dataclass(frozen=True)
class Limits:
    """Limits at which a board disarms itself."""

    silence: float = 0.04
    """Time without a message of the host [s]."""
    longest: float = 3600.0
    """Longest armed time [s]."""
    most_duty: float = 1.0
    current: float | None = None
    """Largest current [A]; default: 1.25 times the largest current of the supply through the element."""

    def check(self) -> None:
        """Raise `InputError` for a duration that the clock of a board cannot measure."""
        count_ticks("`--silence`", self.silence, 1e3)
        count_ticks("`--longest`", self.longest, 1e3)


@dataclass(frozen=True)
class FirmwarePlan:
    """Data of a firmware in addition to its loop."""

    core: CCore
    board: Board
    inputs: BoardInputs
    limits: Limits
    settings: tuple[Setting, ...]
    reference_indices: tuple[int, ...]
    """Places of references and free signals in the inputs of the loop."""
    tuned: tuple[int, ...]
    """Places of tunable gains in the parameters of the loop; their settings are the last ones."""
    drives: int
    """Number of signals, the first outputs of the loop."""
    telemetry_indices: tuple[int, ...]
    """Places of further telemetry in the outputs of the loop."""
    period: float
    """[s]"""
    bounds: tuple[FirmwareBound, ...]
    cuts: bool
    """True if the guard cuts signals at a temperature bound, and does not limit them."""
    digest: int
    alone: StandAlone | None = None

    def telemetry(self) -> list[tuple[str, str]]:
        """Return name and unit of every number of a telemetry, in order."""
        outputs = self.core.outputs
        rows = [(one.name, one.unit) for one in self.inputs.readings]
        rows += [(name_duty(one.name), one.unit) for one in outputs[: self.drives]]
        rows += [(one.name, one.unit) for one in self.inputs.told_channels()]
        return rows + [(outputs[k].name, outputs[k].unit) for k in self.telemetry_indices]


def name_duty(drive: str) -> str:
    """Return the name of the signal of a drive in logs."""
    return "duty" if drive == "drive" else f"duty_{drive}"


def list_settings(
    inputs: BoardInputs, limits: Limits, steps: int, wanted: Sequence[Setting], tuned: Sequence[Setting]
) -> tuple[Setting, ...]:
    """Return all settings in order: in flash, then set by the host.

    Args:
        inputs: measurements of the board.
        limits: limits at which it disarms.
        steps: steps of its converter.
        wanted: references and free signals.
        tuned: tunable gains.

    Raises:
        InputError: there are too many for a message, or the board cannot measure the largest current.
    """
    current = MARGIN * inputs.largest_current if limits.current is None else limits.current
    ranges = [inputs.channels[one.other].gain * steps for one in inputs.readings if one.ratio]
    if ranges and current > min(ranges):
        raise InputError(f"`--most-current` is {current:.3g} A, but the wiring measures at most {min(ranges):.3g} A.")
    settings = [
        Setting("most_duty", "1", limits.most_duty, None, "maximum duty cycle"),
        Setting("least_supply", "V", LOW_SUPPLY * inputs.supply, None, "the board disarms below it"),
        Setting("most_current", "A", current, None, "the board disarms above it"),
        Setting("least_current", "A", LEAST * inputs.largest_current, None, "no resistance is measured below it"),
        Setting("calibrated", "1", 0.0, (0.0, 1.0), "1 if gains and offsets are calibrated"),
    ]
    for one in inputs.channels:
        settings.append(Setting(f"gain {one.name}", f"{one.unit}/step", one.gain, find_gain_range(one), one.parts))
    for one in inputs.channels:
        room = find_offset_range(one, steps)
        settings.append(Setting(f"offset {one.name}", "step", one.offset, room, f"reading at 0 {one.unit}"))
    settings += [*wanted, *tuned]
    if len(settings) > 200:
        raise InputError(f"This loop has {len(settings)} settings; 200 are the most.")
    return tuple(settings)


def check_start(one: Setting) -> None:
    """Raise `InputError` if the first value of a setting is outside its range."""
    if one.range is not None and not one.range[0] <= one.value <= one.range[1]:
        raise InputError(
            f"`{one.name}` starts at {one.value:.4g} {one.unit}, outside its range of {one.range[0]:.4g} to "
            f"{one.range[1]:.4g} {one.unit}: choose a wider `--range`."
        )


def count_ticks(name: str, seconds: float, frequency: float) -> int:
    """Return a duration in ticks of a clock of the board.

    Args:
        name: name of the duration in the error.
        seconds: duration [s].
        frequency: ticks per second [1/s].

    Raises:
        InputError: the duration is shorter than a tick or longer than the clock measures.
    """
    ticks = round(seconds * frequency)
    if not 1 <= ticks <= MOST_TICKS:
        raise InputError(
            f"{name} of {seconds:.6g} s does not fit the clock of the board: choose {1.0 / frequency:g} s to "
            f"{MOST_TICKS / frequency:.6g} s."
        )
    return ticks


def print_settings(plan: FirmwarePlan) -> str:
    """Return the text of `settings.h`."""
    inputs, board, core = plan.inputs, plan.board, plan.core
    channels, readings = inputs.channels, inputs.readings
    gains = 5
    offsets, wanted = gains + len(channels), gains + 2 * len(channels)
    alarm = next((i for i, one in enumerate(core.outputs) if one.name == "alarm"), -1)
    sources = ", ".join(
        f"{{{'APP_RATIO' if one.ratio else 'APP_DIRECT'}, {one.channel}, {one.other}}}" for one in readings
    )
    encoders, extra = sum(one.pin < 0 for one in channels), inputs.told_channels()
    watchdog = choose_watchdog(plan.period, board)
    rows = [
        "/* Numbers of this firmware, printed by martensite. Limits are constants in flash. */",
        "#ifndef SETTINGS_H",
        "#define SETTINGS_H",
        "",
        "#include <stdint.h>",
        "",
        f"#define APP_DIGEST {plan.digest:#010x}UL",
        f"#define APP_BAUD {board.baud}UL",
        f"#define APP_PERIOD {count_ticks('The sample time', plan.period, 1e6)}UL /* us */",
        f"#define APP_SILENCE {count_ticks('`--silence`', plan.limits.silence, 1e3)}UL /* ms without the host */",
        f"#define APP_LONGEST {count_ticks('`--longest`', plan.limits.longest, 1e3)}UL /* ms armed */",
        *_print_alone(plan),
        f"#define APP_STORED {1 + 2 * len(channels)} /* settings that are kept: those of the calibration */",
        f"#define APP_WATCHDOG {watchdog.milliseconds}UL /* ms after a sample, then the board resets */",
        f"#define APP_WATCHDOG_CODE {watchdog.code} /* this time on AVR */",
        f"#define APP_PWM_HZ {round(inputs.frequency)}UL",
        f"#define APP_SETTLE_US {ceil(1e6 * inputs.circuit.settle)}UL /* until an amplifier has settled */",
        f"#define APP_HOLD_US {ceil(1e6 * board.hold)}UL /* from a start to a held input */",
        f"#define APP_SUPPLY_CHANNEL {inputs.supply_channel}",
        f"#define APP_ENCODERS {encoders}",
        f"#define APP_BOUNDS {len(plan.bounds)} /* temperature bounds in the loop */",
        f"#define APP_WARM {_print_float(NEAR)} /* K above the ambient temperature, below which a bound is cold */",
        f"#define APP_CUTS {int(plan.cuts)} /* whether the guard cuts at a bound, and does not limit */",
        f"#define APP_TUNES {len(plan.tuned)} /* gains that the host may set */",
        f"#define APP_TOLD {len(plan.telemetry_indices)} /* outputs of the loop in a telemetry */",
        f"#define APP_DRIVE_PINS {{{', '.join(str(pin) for pin in board.drive_pins[: plan.drives])}}}",
        f"#define APP_CHANNEL_PINS {{{', '.join(str(one.pin) for one in channels)}}}",
        f"#define APP_ALARM {alarm} /* place of the alarm in the outputs of the loop */",
        "",
        "enum {",
        f"    APP_DRIVES = {plan.drives},",
        f"    APP_CHANNELS = {len(channels)},",
        f"    APP_READINGS = {len(readings)},",
        f"    APP_REFERENCES = {len(plan.reference_indices)},",
        f"    APP_SETTINGS = {len(plan.settings)},",
        "    APP_MOST_DUTY = 0,",
        "    APP_LEAST_SUPPLY,",
        "    APP_MOST_CURRENT,",
        "    APP_LEAST_CURRENT,",
        "    APP_CALIBRATED,",
        "    APP_FIXED = APP_CALIBRATED /* settings in flash; the host sets those from here on */",
        "};",
        "",
        f"#define APP_GAIN(channel) ({gains} + (channel))",
        f"#define APP_OFFSET(channel) ({offsets} + (channel))",
        f"#define APP_WANTED(i) ({wanted} + (i))",
        f"#define APP_TUNED(i) ({wanted + len(plan.reference_indices)} + (i))",
        "#define APP_READING(i) (i)",
        "#define APP_AGE(i) (APP_READINGS + (i))",
        "#define APP_REFERENCE(i) (2 * APP_READINGS + (i))",
        "#define APP_SIGNAL(i) (i)",
        "#define APP_STEADY 255 /* no switch interrupts the channel */",
        "",
        "/* A reading: a channel, or one over another. */",
        "enum { APP_DIRECT, APP_RATIO };",
        "typedef struct {",
        "    uint8_t kind, channel, other;",
        "} app_reading;",
        "",
        "/* A setting: its value at the start, and the range within which the host may set it. */",
        "typedef struct {",
        "    float value, low, high;",
        "} app_setting;",
        "",
        "/* A temperature bound in the state of the loop: b' = rate |u| - cooling (b - ambient), below its limit. */",
        "typedef struct {",
        "    uint16_t state, drive;",
        "    float rate, cooling, ambient, limit;",
        "} app_bound;",
        "",
        "#if defined(__AVR__)",
        "#include <avr/pgmspace.h>",
        "#define IN_FLASH PROGMEM",
        "#define FLASH_FLOAT(x) pgm_read_float(&(x))",
        "#define FLASH_U16(x) pgm_read_word(&(x))",
        "#define FLASH_U32(x) pgm_read_dword(&(x))",
        "#else",
        "#define IN_FLASH",
        "#define FLASH_FLOAT(x) (x)",
        "#define FLASH_U16(x) (x)",
        "#define FLASH_U32(x) (x)",
        "#endif",
        "",
        "#ifdef APP_TABLES /* defined where they are used, so that they are there once */",
        f"static const app_reading app_source[] = {{{sources}}};",
        f"static const uint8_t app_told[] = {{{', '.join(map(str, plan.telemetry_indices)) or '0'}}};",
        f"static const uint8_t app_told_channel[] = {{{', '.join(str(int(one in extra)) for one in channels)}}};",
        f"static const uint16_t app_tuned[] IN_FLASH = {{{', '.join(map(str, plan.tuned)) or '0'}}};",
        "static const app_setting app_settings[] IN_FLASH = {",
        *(f"    {_print_setting(one)}" for one in plan.settings),
        "};",
        *_print_bounds(plan.bounds),
        f"static const uint8_t app_pulsed[] = {{{', '.join(str(one.drive % 256) for one in channels)}}};",
        "#define APP_PULSED(i) (app_pulsed[i])",
        "#define APP_SOURCE(i) (app_source[i])",
        "#define APP_TELL(i) (app_told[i])",
        "#define APP_TELL_CHANNEL(i) (app_told_channel[i])",
        "#define APP_PARAMETER(i) FLASH_U16(app_tuned[i])",
        "#define APP_DEFAULT(i) FLASH_FLOAT(app_settings[i].value)",
        "#define APP_LOW(i) FLASH_FLOAT(app_settings[i].low)",
        "#define APP_HIGH(i) FLASH_FLOAT(app_settings[i].high)",
        "#endif",
        "",
        "#endif",
        "",
    ]
    return "\n".join(rows)


def _print_alone(plan: FirmwarePlan) -> list[str]:
    alone, start, pin, samples = plan.alone, 0, 0, 1
    if alone is not None:
        start, pin, samples = STARTS.index(alone.start) + 1, plan.board.arm_pin or 0, alone.samples
    return [
        f"#define APP_ALONE {start} /* 1: armed by a pin, 2: armed after power-up */",
        f"#define APP_ARM_PIN {pin}",
        f"#define APP_SAMPLES {samples}UL /* of a cycle of the reference */",
    ]


def _print_bounds(bounds: Sequence[FirmwareBound]) -> list[str]:
    rows: list[str] = []
    for one in bounds:
        numbers = ", ".join(map(_print_float, (one.rate, one.cooling, one.ambient, one.limit)))
        rows.append(f"    {{{one.state}, {one.drive}, {numbers}}},")
    return ["static const app_bound app_bounds[] IN_FLASH = {", *rows, "};"] if rows else []


def _print_setting(one: Setting) -> str:
    numbers = ", ".join(map(_print_float, (one.value, *(one.range or (one.value, one.value)))))
    return f"{{{numbers}}}, /* {one.name} [{one.unit}]: {one.about} */"


def _print_float(value: float) -> str:
    text = f"{value:.9g}"
    return f"{text}f" if "." in text or "e" in text or "inf" in text else f"{text}.0f"
