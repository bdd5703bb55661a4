"""`hardware calibrate`: gains and offsets of sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.errors import InputError
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.cli.board_options import Armed, BoardSource, open_session
from martensite.cli.commands.hardware import hardware
from martensite.cli.options import Json, Text, read_positive, spread_options

if TYPE_CHECKING:
    pass


@hardware.command("calibrate")
@spread_options
def calibrate(
    source: BoardSource,
    channel: Annotated[Text, Option(help="Channel with a known value, e.g. position.")] = None,
    value: Annotated[Text, Option("--is", help='Known value of the channel, e.g. "0 mm" or "5.02 V".')] = None,
    resistor: Annotated[Text, Option(help='Known resistor in place of the wire, e.g. "10 ohm".')] = None,
    arm: Armed = None,
    nominal: Annotated[bool, Option("--nominal", help="Reset the gains and offsets to their nominal values.")] = False,
    json: Json = False,
) -> None:
    """Set gains and offsets of sensors from known values.

    A channel at 0 sets its offset, at another value its gain, and two points set both. The values are stored in
    calibration.json of the project.
    """
    from martensite.base import units
    from martensite.boards import calibration
    from martensite.show.terminal import print_summary

    chosen = [channel is not None, resistor is not None, nominal]
    if sum(chosen) != 1 or (channel is None) != (value is None):
        raise InputError("Say `--channel NAME --is VALUE`, `--resistor OHMS --arm ARM`, or `--nominal`.")
    with open_session(source) as session:
        if nominal:
            calibration.accept_nominal(session)
            words = (
                "Nominal gains and offsets are taken as they are: readings are as good as the parts of the wiring list."
            )
        elif resistor is not None:
            ohms = read_positive("resistor", resistor, "ohm")
            factor = calibration.calibrate_resistor(session, ohms, word=arm or "")
            words = f"The gain of the current is {factor:.5g} times what it was."
        else:
            name = str(channel)
            si = units.parse_quantity(str(value), calibration.find_channel_unit(session.firmware, name))
            point = calibration.add_point(session, name, si)
            words = f"{name}: {point.steps:.2f} steps, with a spread of {point.spread:.2f}, are {value}."
        settings = {row["name"]: row["value"] for row in session.firmware["settings"] if not row["fixed"]}
    rows = [[name, f"{number:.6g}"] for name, number in settings.items() if name.startswith(("gain", "offset"))]
    blocks: list[Block] = [Sentence(words), DataTable(("setting", "value"), rows, right=(1,))]
    print_summary(Summary("", blocks, settings), json, [source.project / calibration.CALIBRATION])
