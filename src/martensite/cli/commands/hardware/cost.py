"""`hardware cost`: cost of a step on emulated processors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.cli.commands.hardware import hardware
from martensite.cli.options import Json, ScenarioSource, spread_options
from martensite.cli.progress import show_spinner

if TYPE_CHECKING:
    pass


@hardware.command("cost")
@spread_options
def cost(
    source: ScenarioSource,
    part: Annotated[str, Option(help="Evaluated part: loop (code of the board) or plant (model alone).")] = "loop",
    json: Json = False,
) -> None:
    """Measure the time of a step on emulated processors.

    The code runs in float32. AVR cycles are those of the data sheet, counted by simavr. QEMU counts instructions of
    a Cortex-M4, most of which take one cycle and a division 14, so the time is a lower bound.
    """
    from tempfile import TemporaryDirectory

    from martensite.boards.emulators.cost import measure_costs
    from martensite.show.terminal import print_summary

    with TemporaryDirectory() as folder, show_spinner("counting"):
        core, costs = measure_costs(source.load(), part, Path(folder))
    rows = [
        [one.processor, f"{one.most:,} {one.unit}", f"{1e6 * one.time:.4g} us", f"{one.flash:,}", f"{one.ram:,}"]
        for one in costs
    ]
    head = ("processor", "dearest step", "at least" if any(one.least for one in costs) else "time", "flash", "RAM")
    blocks: list[Block] = [Sentence(f"{core.description}, float32"), DataTable(head, rows, right=(1, 2, 3, 4))]
    blocks += [Sentence(f"{one.processor}: a step was not solved in float32.", "bad") for one in costs if one.failed]
    print_summary(Summary("", blocks, {one.processor: vars(one) for one in costs}), json)
