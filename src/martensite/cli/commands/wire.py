"""`wire`: what a piece of wire, or a coil, at hand needs, and what it does."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from martensite.base.errors import ParameterError
from martensite.cli.app import app
from martensite.cli.options import Text, read_quantity, refuse_idle, spread_options
from martensite.cli.outputs import AnswerOptions
from martensite.cli.progress import show_spinner

if TYPE_CHECKING:
    from martensite.design.sizing.wire_in_hand import WireInHand

USUAL = '--diameter "0.1 mm" --length "10 cm"'


@dataclass(frozen=True)
class WireOptions:
    """A wire or a coil, what drives it and what it pulls, as the command line says it."""

    diameter: Annotated[Text, Option(help='Of the wire, e.g. "0.1 mm".')] = None
    length: Annotated[Text, Option(help='Of the wire, e.g. "10 cm"; of a coil, if it is known.')] = None
    supply: Annotated[Text, Option(help='Voltage of the supply, e.g. "5 V".')] = None
    current_limit: Annotated[Text, Option(help='Largest current of the supply, e.g. "2 A".')] = None
    load: Annotated[Text, Option(help='Weight that hangs on it, e.g. "100 gf" [default: the maker\'s pull].')] = None
    spring: Annotated[Text, Option(help='Rate of a spring instead, e.g. "0.1 N/mm".')] = None
    preload: Annotated[Text, Option(help='Force of the spring when cold, e.g. "1 N".')] = None
    pulse: Annotated[Text, Option(help="Time in which it is to contract [default: 1 s].")] = None
    ambient: Annotated[Text, Option(help="Temperature around it [default: 22 degC].")] = None
    resistance: Annotated[Text, Option(help="As measured [default: the maker's].")] = None
    solid: Annotated[Text, Option(help='Length of the closed coil, e.g. "25 mm".')] = None
    turns: Annotated[Text, Option(help="Number of its turns, if they were counted.")] = None
    outer: Annotated[Text, Option(help='Coil diameter over all, e.g. "5 mm".')] = None
    stretched: Annotated[Text, Option(help='Length to which it is drawn out when cold, e.g. "100 mm".')] = None

    def read(self, coil: bool, alloy: str, cooling: str) -> WireInHand:
        """The wire or the coil."""
        from martensite.design.sizing.coil_in_hand import CoilInHand
        from martensite.design.sizing.wire_in_hand import WireInHand

        needed = ("diameter", "supply") if coil else ("diameter", "length", "supply")
        missing = [f"`--{name}`" for name in needed if getattr(self, name) is None]
        if missing:
            usual = '--coil --diameter "0.5 mm" --solid "25 mm" --resistance "3 ohm"' if coil else USUAL
            raise ParameterError(
                f'Option {", ".join(missing)} is needed; write for example `martensite wire {usual} --supply "5 V"`.'
            )
        kind = CoilInHand if coil else WireInHand
        values: dict[str, Any] = {"alloy": alloy, "cooling": cooling}
        for name, text in vars(self).items():
            if text is not None:
                refuse_idle(f"--{name}", name not in kind.declarations, "it says something of a coil; add --coil")
                values[name] = read_quantity(name, text, kind.declarations[name].unit)
        return kind(**values)


@app.command("wire", rich_help_panel="Design")
@spread_options
def wire(
    piece: WireOptions,
    answer: AnswerOptions,
    coil: Annotated[bool, Option("--coil", help="It is a coil spring, wound closed.")] = False,
    cooling: Annotated[str, Option(help="air, horizontal (still air), fan (2 m/s), water, or oil.")] = "air",
    alloy: Annotated[str, Option(help="70 or 90.")] = "90",
    save: Annotated[Path | None, Option(help="Scenario to write: .toml.")] = None,
) -> None:
    """Say what current a wire or a coil needs, and what it does.

    Exits with 1 where the supply cannot make it contract, or it does not come back.
    """
    outputs = answer.check_files(save, ".toml")
    asked = piece.read(coil, alloy, cooling)
    with show_spinner("simulating it"):
        from martensite.design.sizing.scenario import format_ratings
        from martensite.design.sizing.wire_ratings import rate_wire
        from martensite.physics.materials.wires import load_wires

        found = rate_wire(asked)
    from martensite.show.figures.circuit import plot_circuit
    from martensite.show.summaries.wire_ratings import summarise_ratings

    outputs.answer(
        summarise_ratings(found), answer.json, lambda: format_ratings(found, load_wires()), lambda: plot_circuit(found)
    )
    if found.faults:
        from typer import Exit

        raise Exit(1)
