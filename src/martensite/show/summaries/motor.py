"""A DC motor: its constants, and what is doubtful."""

from __future__ import annotations

from martensite.base.confidence import LEVEL
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.characterise.motor_constants import UNITS, MotorConstants

SYMBOLS = {
    "resistance": "R",
    "inductance": "L",
    "constant": "K_T = K_B",
    "friction": "b",
    "dry_friction": "F_c",
    "inertia": "J",
}


def summarise_motor(found: MotorConstants, states: int) -> Summary:
    """Everything about a motor that was found from so many steady states."""
    rows = [
        (f"{symbol}, {name.replace('_', ' ')}", getattr(found, name).write(), UNITS[name])
        for name, symbol in SYMBOLS.items()
        if getattr(found, name) is not None
    ]
    blocks: list[Block] = [
        DataTable(("constant", "value", "unit"), rows, right=(1,)),
        Sentence(f"± half the {100 * LEVEL:g} % interval; a number that was given has none."),
    ]
    if found.run_up_time is not None:
        blocks.append(Sentence(f"R J/(K_T K_B) = {found.run_up_time:.4g} s"))
    blocks += [Sentence(remark, "caution") for remark in found.remarks]
    return Summary(f"DC motor from {states} steady states", blocks, found.to_dict())
