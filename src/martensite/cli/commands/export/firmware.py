"""`export firmware`: firmware for the loop of a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.cli.board_options import require_empty
from martensite.cli.commands.export import export
from martensite.cli.options import Force, Json, ScenarioSource, Text, Texts, read_positive, spread_options

if TYPE_CHECKING:
    from martensite.boards.firmware.project import Firmware
    from martensite.boards.firmware.settings import FirmwarePlan, Setting


@export.command("firmware")
@spread_options
def firmware(
    source: ScenarioSource,
    board: Annotated[str, Option(help="Board: uno, nano, mega2560, esp32 or stm32f405.")],
    out: Annotated[Path | None, Option(metavar="FOLDER", help="Output folder [default: ./SCENARIO_BOARD].")] = None,
    silence: Annotated[
        str, Option(help='Time without a message of the host after which the board disarms, e.g. "0.5 s".')
    ] = "40 ms",
    longest: Annotated[str, Option(help='Maximum time for which the board stays armed, e.g. "10 min".')] = "1 h",
    most_duty: Annotated[float, Option(help="Maximum duty cycle, 0 to 1.")] = 1.0,
    most_current: Annotated[
        Text,
        Option(
            help=(
                'Current above which the board disarms, e.g. "1 A" [default: 1.25 times the current of the full '
                "command]."
            )
        ),
    ] = None,
    ranges: Annotated[
        Texts,
        Option(
            "--range",
            metavar="NAME=LOW:HIGH",
            help='Range of a reference or of a tunable gain that the host may set, e.g. "reference=0 mm:4 mm"; '
            "repeatable.",
        ),
    ] = None,
    stand_alone: Annotated[
        Text,
        Option(
            metavar="pin|power-up",
            help="Operation without a host on uno, nano or mega2560: armed by a switch at a pin, or after power-up.",
        ),
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write the firmware of a control loop: code, guard and wiring.

    The loop is first tested in float32 over the scenario. The board heats only after the host has armed it. It
    disarms if the host is silent, the supply voltage is low or the current is too large.
    """
    from martensite.boards.firmware.project import build_firmware
    from martensite.boards.firmware.ranges import read_ranges
    from martensite.boards.firmware.settings import Limits
    from martensite.show.terminal import print_summary

    if not 0.0 < most_duty <= 1.0:
        raise InputError(f"Option `--most-duty` must be above 0 and at most 1, but is {most_duty:g}.")
    limits = Limits(
        read_positive("silence", silence, "s"),
        read_positive("longest", longest, "s"),
        most_duty,
        read_positive("most-current", most_current, "A"),
    )
    folder = require_empty(out or Path(f"{source.file.stem}_{board}"), force)
    written = build_firmware(
        source.load(),
        board,
        name=folder.resolve().name,
        limits=limits,
        ranges=read_ranges(ranges or []),
        alone=stand_alone,
    )
    files = written.write(folder)
    print_summary(_summarise_firmware(written), json, files)


def _summarise_firmware(firmware: Firmware) -> Summary:
    from martensite.boards.firmware.wiring import describe_measurement

    plan = firmware.plan
    count = sum(plan.core.operations["step"].values())
    rows = [[one.name, f"{one.value:.4g}", one.unit, _write_range(one), one.about] for one in plan.settings]
    data = {
        "board": plan.board.name,
        "digest": plan.digest,
        "tried": firmware.tried,
        "operations": plan.core.operations,
    }
    blocks: list[Block] = [
        Sentence(f"{plan.core.description}, for {plan.board.title}"),
        Sentence(f"model: {plan.core.size:,} bytes; a step takes at most {count} operations"),
        Sentence(firmware.tried),
        DataTable(("setting", "value", "unit", "host may set", "about"), rows, right=(1,)),
        *_warn_of_room(firmware),
        Sentence(describe_measurement(plan)),
        *_describe_alone(plan),
        Sentence(_describe_limits(plan)),
        Sentence("Gains and offsets are nominal: calibrate the board before it arms on its own readings.", "caution"),
    ]
    return Summary("", blocks, data)


def _write_range(one: Setting) -> str:
    return "no" if one.range is None else f"{one.range[0]:.4g} to {one.range[1]:.4g}"


def _warn_of_room(firmware: Firmware) -> list[Block]:
    from martensite.boards.firmware.boards import LARGER

    board = firmware.plan.board
    if firmware.flash <= board.flash:
        return []
    words = (
        f"It may not fit: by the length of its C it takes about {1e-3 * firmware.flash:.0f} kB of flash, and the board "
        f"has {1e-3 * board.flash:.0f} kB. Take {LARGER}."
    )
    return [Sentence(words, "bad")]


def _describe_alone(plan: FirmwarePlan) -> list[Block]:
    alone = plan.alone
    if alone is None:
        return []
    pin = f"while a switch closes pin {plan.board.arm_pin} to ground, if it was open before"
    how = pin if alone.start == "pin" else "after power-on, and never after a watchdog or a fault"
    words = (
        f"Stand-alone: the board arms {how}, with the calibration in its EEPROM. It follows the reference of the "
        f"scenario, which repeats every {alone.samples * plan.period:.4g} s"
    )
    if alone.follows is not None:
        again = plan.limits.silence + alone.follows + max((one.cooling_time for one in plan.bounds), default=0.0)
        words += f". It follows again within {again:.3g} s of a power cycle"
    return [Sentence(f"{words}.")]


def _describe_limits(plan: FirmwarePlan) -> str:
    from martensite.boards.firmware.watchdog import choose_watchdog

    limits, fixed = plan.limits, {one.name: one.value for one in plan.settings if one.fixed}
    words = [
        f"{1e3 * limits.silence:g} ms after it heard the host last",
        f"after {limits.longest:g} s armed",
        "when the loop cannot be solved",
        "when a sample is late by a period",
    ]
    if plan.inputs.supply_channel >= 0:
        words.append(f"below {fixed['least_supply']:.3g} V of supply")
    if plan.inputs.measures_resistance:
        words.append(f"above {fixed['most_current']:.3g} A")
    own = "The scenario has no guard of its own."
    if any(one.name == "alarm" for one in plan.core.outputs):
        own = "The guard of the scenario is in the loop."
    for one in plan.bounds:
        own += (
            f" It keeps the element below {one.limit - 273.15:.4g} °C + {one.find_margin(plan.period):.2g} K if the "
            f"element cools as declared; after a reset it takes {one.cooling_time:.2g} s until it counts as cold."
        )
    watchdog = choose_watchdog(plan.period, plan.board)
    own += (
        f" The watchdog resets the board {watchdog.milliseconds} ms after the last sample."
        if watchdog.real
        else f" The firmware of {plan.board.title} has no watchdog: if it hangs, the heating stays on."
    )
    return f"The board disarms by itself {', '.join(words)}; no duty is above {limits.most_duty:g}. {own}"
