"""Cost of a step on emulated processors: cycles on AVR, instructions on Cortex-M4, and bytes.

simavr counts cycles as in the data sheet. QEMU counts instructions, which take 1 to 14 cycles each on a Cortex-M4;
times at one cycle each are lower bounds, and are labelled so.
"""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import InputError, SolveError
from martensite.boards.emulators.avr import SimavrBoard
from martensite.boards.emulators.cortex import MACHINE
from martensite.boards.emulators.toolchains import read_sizes, require_tool, run_tool
from martensite.boards.firmware.boards import find_board

if TYPE_CHECKING:
    from martensite.export.c_core import CCore
    from martensite.scenario.scenario import Scenario

TICK = 1e3 / 168.0
"""Instructions per tick of SysTick under QEMU, with one instruction per nanosecond."""
STEPS, PLAYED, LONGEST = 400, 150, 600
"""Steps of a scenario, and played steps: of a plant spread over it, of a loop from its start."""
AVR_FLAGS = ("-mmcu=atmega2560", "-DF_CPU=16000000L", "-std=gnu11", "-O2")
ARM_FLAGS = ("-std=gnu11", "-O2", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
ARM_LINK = ("-T", "stm32f405.ld", "-nostartfiles", "--specs=nano.specs", "--specs=nosys.specs")


@dataclass(frozen=True)
class StepCost:
    """Cost of a step of a core on a processor."""

    processor: str
    most: int
    """Cycles of AVR or instructions of Cortex-M4 in the longest step."""
    flash: int
    """Flash of the core, its library, and the program around it [bytes]."""
    ram: int
    """[bytes]"""
    failed: bool
    """True if a step did not solve in float32."""
    unit: str
    """Unit of `most`: cycles or instructions."""
    clock: float
    """[Hz]"""

    @property
    def time(self) -> float:
        """Return the time of the longest step [s], at one cycle per instruction."""
        return self.most / self.clock

    @property
    def least(self) -> bool:
        """Return whether the time is a lower bound."""
        return self.unit == "instructions"


def measure_costs(scenario: Scenario, part: str, folder: Path) -> tuple[CCore, list[StepCost]]:
    """Return a core of a scenario in float32, and the costs of its steps on emulated processors.

    Args:
        scenario: played scenario.
        part: `loop` (observers, controllers and supervisor) or `plant`.
        folder: folder of the programs.

    Raises:
        InputError: the part is unknown, the scenario has no loop, or a tool is missing.
        SolveError: a program does not end.
    """
    from martensite.export.c_core import build_c_core, build_c_loop
    from martensite.export.c_example import list_loop_inputs, list_run_inputs

    if part == "loop" and scenario.bench is not None:
        core = build_c_loop(scenario.bench, name="core", precision="float32")
        first, played = list_loop_inputs(scenario.bench, scenario.waveform, scenario.run(), STEPS)
    elif part == "plant":
        core = build_c_core(scenario.system, name="core", precision="float32")
        first, played = list_run_inputs(scenario.system, scenario.waveform, scenario.duration, STEPS)
    else:
        raise InputError(f"There is no part `{part}` of this scenario; there are loop, if it has one, and plant.")
    steps = [length for length, _ in played]
    whole = [row for length, row in played if length == max(steps)]
    rows = [first, *whole[:: max(1, len(whole) // PLAYED)][:PLAYED]]
    if part == "loop":  # a loop needs all samples
        rows = [first, *(row for _, row in played)][:LONGEST]
    write_cost(core, rows, max(steps), folder)
    table = 4 * len(rows) * len(first)  # the played rows do not belong to a core
    costs = [cost_on_avr(core, folder), cost_on_cortex(core, folder)]
    return core, [replace(one, flash=one.flash - table) for one in costs]


def write_cost(core: CCore, rows: Sequence[Sequence[float]], period: float, folder: Path) -> None:
    """Write the core, rows of inputs, and the program that plays them into a folder."""
    table = ", ".join("{" + ", ".join(f"{x:.9e}f" for x in row) + "}" for row in rows)
    name = core.name
    numbers = {
        "CORE(f)": f"{name}_##f",
        "CORE_MODEL": f"{name}_model",
        "CORE_REAL": f"{name}_real",
        "CORE_INPUTS": f"{name}_INPUTS",
        "COST_ROWS": str(len(rows)),
        "COST_PERIOD": f"{period:.9e}f",
        "COST_TABLE": "{" + table + "}",
    }
    lines = [f'#include "{name}.h"', *(f"#define {key} {value}" for key, value in numbers.items()), ""]
    (folder / "cost.h").write_text("\n".join(lines), "utf-8")
    core.write(folder)
    home = files("martensite.boards")
    (folder / "cost.c").write_text((home / "emulators" / "cost.c").read_text("utf-8"), "utf-8")
    for one in ("start_stm32f405.c", "stm32f405.ld", "app.h"):
        (folder / one).write_text((home / "c" / one).read_text("utf-8"), "utf-8")


def cost_on_avr(core: CCore, folder: Path) -> StepCost:
    """Return the cycles of the longest step on an ATmega2560 at 16 MHz.

    Raises:
        InputError: a tool is missing.
        SolveError: the program does not end.
    """
    elf = folder / "cost_avr.elf"
    run_tool([require_tool("avr-gcc"), *AVR_FLAGS, "cost.c", f"{core.name}.c", "-lm", "-o", elf], folder)
    board = SimavrBoard(elf, "mega2560", 500_000, folder)
    try:
        for _ in range(3000):
            board.run(0.05)
            if board.marks[2] and board.cycles > 0 and _is_done(board):
                break
        else:
            raise SolveError("The program that counts does not end.")
        most = board.marks[2] - board.marks[1]
        failed = board.marks[3] > 0
    finally:
        board.close()
    return StepCost("ATmega2560", most, *read_sizes("avr-size", elf), failed, "cycles", find_board("mega2560").clock)


def _is_done(board: SimavrBoard) -> bool:
    before = board.marks
    board.run(0.5)
    return board.marks == before


def cost_on_cortex(core: CCore, folder: Path) -> StepCost:
    """Return the instructions of the longest step on a Cortex-M4F.

    Raises:
        InputError: a tool is missing.
        SolveError: the program does not end.
    """
    elf = folder / "cost_arm.elf"
    sources = ("cost.c", f"{core.name}.c", "start_stm32f405.c")
    run_tool([require_tool("arm-none-eabi-gcc"), *ARM_FLAGS, *sources, *ARM_LINK, "-lm", "-o", elf], folder)
    command = [require_tool("qemu-system-arm"), "-M", MACHINE, "-nographic", "-monitor", "none", "-serial", "null"]
    command += ["-semihosting-config", "enable=on,target=native", "-icount", "shift=0", "-kernel", str(elf)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    numbers = [int(line) for line in (done.stdout + done.stderr).split()]
    if len(numbers) != 6:
        raise SolveError(f"The program that counts said {done.stderr[:200]!r}.")
    most = round(TICK * (numbers[2] - numbers[0]))
    sizes = read_sizes("arm-none-eabi-size", elf)
    return StepCost("Cortex-M4F", most, *sizes, numbers[4] > 0, "instructions", find_board("stm32f405").clock)
