"""A complete firmware project around the loop of a scenario.

The loop is the C code of `martensite export c --part loop` in float32, tried over the scenario first. The project adds
the application (`app.c`), the link (`link.c`), the board layer (`board_*.c`), and all numbers in `settings.h`. It
allocates no memory, prints no text, and arms only on the word of the host.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import InputError
from martensite.base.files import make_folder, replace_together, write_file
from martensite.boards.firmware.alone import plan_alone, print_reference
from martensite.boards.firmware.boards import LARGER, Board, find_board
from martensite.boards.firmware.bounds import list_bounds
from martensite.boards.firmware.channels import plan_inputs
from martensite.boards.firmware.drawing import draw_wiring
from martensite.boards.firmware.host_library import print_host_library
from martensite.boards.firmware.parts_list import describe_elements
from martensite.boards.firmware.ranges import choose_tuned, find_input_ranges, parse_range
from martensite.boards.firmware.settings import (
    TOLD,
    FirmwarePlan,
    Limits,
    Setting,
    check_start,
    list_settings,
    print_settings,
)
from martensite.boards.firmware.wiring import describe_wiring
from martensite.boards.link.messages import VERSION, print_header
from martensite.control.loop.names import list_references
from martensite.control.loop.run import reference_waveforms
from martensite.control.supervisors.guard import Guard

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.export.c_names import CoreVariable
    from martensite.scenario.scenario import Scenario
    from martensite.simulate.result import Result

SHARED = ("app.c", "app.h", "alone_mode.h", "board.h", "link.c", "link.h")
LAYERS = {
    "arduino": ("board_arduino.cpp", "guard_arduino.cpp", "alone_mode.c"),
    "stm32f405": ("board_stm32f405.c", "guard_stm32f405.c", "start_stm32f405.c", "stm32f405.ld"),
}
TRIED_SAMPLES = 400
"""Least number of samples of the trial of the loop."""

AROUND, PER_LETTER = 8000.0, 1.2
"""Flash on an AVR [bytes] of a firmware without its loop, and per letter of its C code; from four examples."""
TOO_LARGE = 1.25
"""Approximate flash over the flash of a board above which the firmware is refused."""


@dataclass(frozen=True)
class Firmware:
    """A project in memory."""

    name: str
    plan: FirmwarePlan
    texts: Mapping[str, str]
    tried: str
    """Extent of the trial of the loop in float32, in a sentence."""

    @property
    def flash(self) -> float:
        """Return the approximate flash on an AVR [bytes]; 0 for other processors."""
        if not self.plan.board.avr:
            return 0.0
        return AROUND + PER_LETTER * len(self.plan.core.source)

    def check_size(self) -> None:
        """Raise `InputError` if the firmware is much larger than the flash of its board."""
        board = self.plan.board
        if self.flash > TOO_LARGE * board.flash:
            raise InputError(
                f"This loop takes about {1e-3 * self.flash:.0f} kB of flash, but {board.title} has "
                f"{1e-3 * board.flash:.0f} kB: use {LARGER}."
            )

    def write(self, folder: str | Path) -> list[Path]:
        """Write all files, or none, into a folder, and return their paths.

        Raises:
            DataError: the folder cannot be written.
        """
        home = Path(folder)
        for one in {(home / name).parent for name in self.texts}:
            make_folder(one)
        with replace_together():
            for name, text in self.texts.items():
                write_file(home / name, text)
        (home / "firmware.elf").unlink(missing_ok=True)  # it was compiled from other files
        return [home / name for name in self.texts]


def build_firmware(
    scenario: Scenario,
    board: str,
    *,
    name: str = "firmware",
    limits: Limits | None = None,
    ranges: Mapping[str, str] | None = None,
    alone: str | None = None,
) -> Firmware:
    """Return the firmware of the loop of a scenario for a board.

    Args:
        scenario: scenario with a controller.
        board: board, such as `uno` or `stm32f405`.
        name: name of the sketch and of its folder.
        limits: limits at which the board disarms itself.
        ranges: ranges `LOW:HIGH` of references and tunable gains that the host may set, by name. By default a reference
            has the range of the scenario, and no gain is tunable.
        alone: `pin` or `power-up` for operation without a host.

    Raises:
        InputError: the board is unknown, the scenario has no loop, the board lacks inputs or outputs, or a range is
            wrong.
        ParameterError: the loop fails in float32.
    """
    from martensite.export.c_core import build_c_loop
    from martensite.export.c_example import MOST_TRIED, list_loop_inputs, try_program

    chosen, bench = find_board(board), scenario.bench
    if bench is None:
        raise InputError("Firmware is written around a loop: this scenario has no controller.")
    chosen_limits = limits or Limits()
    chosen_limits.check()
    core = build_c_loop(bench, name="loop", precision="float32")
    run = scenario.run()
    tried = try_program(core, list_loop_inputs(bench, scenario.waveform, run, TRIED_SAMPLES, MOST_TRIED))
    inputs = plan_inputs(bench, chosen)
    drives, readings = len(bench.plant.drives()), len(inputs.readings)
    if drives > len(chosen.drive_pins):
        raise InputError(f"{chosen.title} drives {len(chosen.drive_pins)} switches here, but the loop has {drives}.")
    others, given = core.inputs[2 * readings :], ranges or {}
    tuned = choose_tuned(core, given, [one.name for one in others])
    gains = [one for one in core.parameters if one.name in tuned]
    turned = [Setting(one.name, one.unit, one.default, tuned[one.name], "gain") for one in gains]
    planned = plan_alone(alone, chosen, bench, scenario.duration, [one.name for one in others], run)
    input_settings = _list_inputs(bench, others, run, scenario.duration, given)
    settings = list_settings(inputs, chosen_limits, chosen.steps, input_settings, turned)
    room = TOLD - readings - drives - len(inputs.told_channels())
    more = [k for k in range(drives, len(core.outputs)) if core.outputs[k].name != "alarm"]  # every telemetry has it
    reported = tuple(more[: max(room, 0)])
    digest = zlib.crc32("".join([core.header, core.source, *map(repr, settings), repr(planned)]).encode())
    wanted = tuple(range(2 * readings, len(core.inputs)))
    places = tuple(one.index for one in gains)
    plan = FirmwarePlan(
        core,
        chosen,
        inputs,
        chosen_limits,
        settings,
        wanted,
        places,
        drives,
        reported,
        bench.period,
        list_bounds(bench),
        isinstance(bench.supervisor, Guard) and bench.supervisor.answer != "limit",
        digest,
        planned,
    )
    firmware = Firmware(name, plan, _collect_texts(name, plan, scenario, describe_elements(bench)), tried)
    firmware.check_size()
    return firmware


def _list_inputs(
    bench: Bench, inputs: Sequence[CoreVariable], run: Result, duration: float, given: Mapping[str, str]
) -> list[Setting]:
    """Return the settings of references and free signals, with their first values and their ranges."""
    initial = {name: wave.value(0.0) for name, wave in reference_waveforms(bench).items()}
    initial |= {name: float(run.columns[name][0]) for name in list_references(bench)}
    allowed = find_input_ranges(bench, [one.name for one in inputs], duration)
    allowed |= {one.name: parse_range(one.name, given[one.name], one.unit) for one in inputs if one.name in given}
    settings: list[Setting] = []
    for one in inputs:
        settings.append(Setting(one.name, one.unit, initial.get(one.name, 0.0), allowed[one.name], "input of the loop"))
        check_start(settings[-1])
    return settings


def _collect_texts(name: str, plan: FirmwarePlan, scenario: Scenario, elements: list[str]) -> dict[str, str]:
    home, board = files("martensite.boards") / "c", plan.board
    texts = {one: (home / one).read_text("utf-8") for one in (*SHARED, *LAYERS[board.layer])}
    texts |= print_host_library(plan)
    texts |= plan.core.files | {"settings.h": print_settings(plan), "messages.h": print_header()}
    texts["firmware.json"] = json.dumps(describe_firmware(name, plan, scenario.text), indent=1) + "\n"
    texts["WIRING.md"] = describe_wiring(name, plan, elements)
    texts["wiring.svg"] = draw_wiring(plan, elements)
    if plan.alone is not None:
        texts["reference.h"] = print_reference(plan.alone)
    if board.layer == "arduino":
        texts[f"{name}.ino"] = (home / "firmware.ino").read_text("utf-8")
        texts["platformio.ini"] = _print_platformio(board)
    else:
        texts["Makefile"] = _MAKEFILE
    return texts


def describe_firmware(name: str, plan: FirmwarePlan, scenario: str) -> dict[str, Any]:
    """Return the description of a firmware for a host: telemetry and settings with units, and the scenario."""
    core = plan.core
    return {
        "name": name,
        "board": plan.board.name,
        "link": VERSION,
        "digest": plan.digest,
        "period": plan.period,
        "alone": plan.alone.start if plan.alone else None,
        "telemetry": [{"name": one, "unit": unit} for one, unit in plan.telemetry()],
        "readings": len(plan.inputs.readings),
        "drives": plan.drives,
        "settings": [
            {"name": one.name, "unit": one.unit, "value": one.value, "fixed": one.fixed, "range": one.range}
            for one in plan.settings
        ],
        "parameters": [{"name": one.name, "unit": one.unit} for one in core.parameters],
        "operations": core.operations["step"],
        "scenario": scenario,
    }


def _print_platformio(board: Board) -> str:
    return f"""; pio run, pio run -t upload
[platformio]
src_dir = .

[env:{board.name}]
platform = {board.platformio["platform"]}
board = {board.platformio["board"]}
framework = arduino
build_flags = -O2 -ffp-contract=off
{_FUSES if board.avr else ""}"""


_FUSES = """; brown-out reset below 4.3 V, needed at 16 MHz: pio run -t fuses, with an ISP programmer
board_fuses.efuse = 0xfc
"""


_MAKEFILE = """# make: firmware.elf, with arm-none-eabi-gcc
# Once per chip, for a brown-out reset below 2.7 V: STM32_Programmer_CLI -c port=SWD -ob BOR_LEV=0
CC = arm-none-eabi-gcc
CFLAGS = -std=c99 -O2 -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -ffp-contract=off
CFLAGS += -Wall -Wextra -Wtype-limits
LDFLAGS = -T stm32f405.ld -nostartfiles --specs=nano.specs --specs=nosys.specs
SOURCES = app.c link.c loop.c board_stm32f405.c guard_stm32f405.c start_stm32f405.c

firmware.elf: $(SOURCES) app.h board.h link.h loop.h messages.h settings.h stm32f405.ld
\t$(CC) $(CFLAGS) $(SOURCES) $(LDFLAGS) -o $@ -lm

clean:
\trm -f firmware.elf
"""
