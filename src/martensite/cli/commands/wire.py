"""`wire`: needs and performance of a given wire or coil."""

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
    """Wire or coil, drive and load."""

    diameter: Annotated[Text, Option(help='Wire diameter, e.g. "0.1 mm".')] = None
    length: Annotated[Text, Option(help='Wire length, e.g. "10 cm"; optional for a coil.')] = None
    supply: Annotated[Text, Option(help='Supply voltage, e.g. "5 V".')] = None
    current_limit: Annotated[Text, Option(help='Maximum current of the supply, e.g. "2 A".')] = None
    load: Annotated[
        Text, Option(help=('Weight that hangs on the wire, e.g. "100 gf" [default: the pull of the maker\'s table].'))
    ] = None
    spring: Annotated[Text, Option(help='Rate of a return spring instead of a weight, e.g. "0.1 N/mm".')] = None
    preload: Annotated[Text, Option(help='Force of the spring in the cold state, e.g. "1 N".')] = None
    pulse: Annotated[Text, Option(help="Contraction time [default: 1 s].")] = None
    ambient: Annotated[Text, Option(help="Ambient temperature [default: 22 degC].")] = None
    resistance: Annotated[
        Text, Option(help='Measured resistance, e.g. "3 ohm" [default: that of the maker\'s table].')
    ] = None
    solid: Annotated[Text, Option(help='Length of the closed coil, e.g. "25 mm".')] = None
    turns: Annotated[Text, Option(help="Number of turns of the coil, e.g. 50.")] = None
    outer: Annotated[Text, Option(help='Outer coil diameter, e.g. "5 mm".')] = None
    stretched: Annotated[Text, Option(help='Length to which the cold coil is stretched, e.g. "100 mm".')] = None

    def read(self, coil: bool, alloy: str, cooling: str) -> WireInHand:
        """Return the wire or coil."""
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
    coil: Annotated[bool, Option("--coil", help="Rate a closed-wound coil spring instead of a straight wire.")] = False,
    cooling: Annotated[
        str, Option(help="Cooling: air (vertical wire), horizontal (still air), fan (2 m/s), water, or oil.")
    ] = "air",
    alloy: Annotated[str, Option(help="Alloy by transition temperature: 70 or 90.")] = "90",
    out: Annotated[Path | None, Option(help="Scenario file to write: .toml.")] = None,
) -> None:
    """Compute the current of a given wire or coil, and its motion.

    The exit code is 1 if the supply cannot contract the wire or the wire does not return.
    """
    outputs = answer.check_files(out, ".toml")
    given_wire = piece.read(coil, alloy, cooling)
    with show_spinner("simulating it"):
        from martensite.design.sizing.scenario import format_ratings
        from martensite.design.sizing.wire_ratings import rate_wire
        from martensite.physics.materials.wires import load_wires

        rating = rate_wire(given_wire)
    from martensite.show.figures.circuit import plot_circuit
    from martensite.show.summaries.wire_ratings import summarise_ratings

    outputs.answer(
        summarise_ratings(rating),
        answer.json,
        lambda: format_ratings(rating, load_wires()),
        lambda: plot_circuit(rating),
        wrap=True,
    )
    if rating.faults:
        from typer import Exit

        raise Exit(1)
