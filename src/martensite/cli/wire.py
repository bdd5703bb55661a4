"""`wire`: what a piece of wire, or a coil, at hand needs, and what it does."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from martensite.base.errors import ParameterError
from martensite.cli.app import app
from martensite.cli.options import FigureFile, Force, Json, Text, read_quantity, refuse_idle
from martensite.cli.outputs import Outputs
from martensite.cli.progress import show_spinner

if TYPE_CHECKING:
    from martensite.design.sizing.wire_in_hand import WireInHand

USUAL = '--diameter "0.1 mm" --length "10 cm"'


@app.command()
def wire(
    diameter: Annotated[Text, Option(help='Of the wire, e.g. "0.1 mm".')] = None,
    length: Annotated[Text, Option(help='Of the wire, e.g. "10 cm"; of a coil, if it is known.')] = None,
    supply: Annotated[Text, Option(help='Voltage of the supply, e.g. "5 V".')] = None,
    current_limit: Annotated[Text, Option(help='Largest current of the supply, e.g. "2 A".')] = None,
    load: Annotated[Text, Option(help='Weight that hangs on it, e.g. "100 gf" [default: the maker\'s pull].')] = None,
    spring: Annotated[Text, Option(help='Rate of a spring instead, e.g. "0.1 N/mm".')] = None,
    preload: Annotated[Text, Option(help='Force of the spring when cold, e.g. "1 N".')] = None,
    pulse: Annotated[Text, Option(help="Time in which it is to contract [default: 1 s].")] = None,
    ambient: Annotated[Text, Option(help="Temperature around it [default: 22 degC].")] = None,
    cooling: Annotated[str, Option(help="air, horizontal (still air), fan (2 m/s), water, or oil.")] = "air",
    alloy: Annotated[str, Option(help="70 or 90.")] = "90",
    resistance: Annotated[Text, Option(help="As measured [default: the maker's].")] = None,
    coil: Annotated[bool, Option("--coil", help="It is a coil spring, wound closed.")] = False,
    solid: Annotated[Text, Option(help='Length of the closed coil, e.g. "25 mm".')] = None,
    turns: Annotated[Text, Option(help="Number of its turns, if they were counted.")] = None,
    outer: Annotated[Text, Option(help='Coil diameter over all, e.g. "5 mm".')] = None,
    stretched: Annotated[Text, Option(help='Length to which it is drawn out when cold, e.g. "100 mm".')] = None,
    save: Annotated[Path | None, Option(help="Scenario to write: .toml.")] = None,
    figure: FigureFile = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Say what current a wire or a coil needs, and what it does.

    Exits with 1 where the supply cannot make it contract, or it does not come back.
    """
    given = {
        "diameter": diameter,
        "length": length,
        "supply": supply,
        "current_limit": current_limit,
        "load": load,
        "spring": spring,
        "preload": preload,
        "pulse": pulse,
        "ambient": ambient,
        "resistance": resistance,
    }
    own = {"solid": solid, "turns": turns, "outer": outer, "stretched": stretched}
    for name, value in own.items():
        refuse_idle(f"--{name}", value is not None and not coil, "it says something of a coil; add --coil")
    outputs = Outputs(save, figure).check(force, data=(".toml",))
    asked = _read_wire(given | own if coil else given, coil, {"alloy": alloy, "cooling": cooling})
    with show_spinner("simulating it"):
        from martensite.design.sizing.scenario import format_ratings
        from martensite.design.sizing.wire_ratings import rate_wire
        from martensite.physics.materials.wires import load_wires

        found = rate_wire(asked)
    from martensite.show.figures.circuit import plot_circuit
    from martensite.show.summaries.sizing import summarise_ratings

    outputs.answer(
        summarise_ratings(found), json, lambda: format_ratings(found, load_wires()), lambda: plot_circuit(found)
    )
    if found.faults:
        from typer import Exit

        raise Exit(1)


def _read_wire(given: dict[str, Text], coil: bool, chosen: dict[str, Any]) -> WireInHand:
    from martensite.design.sizing.coil_in_hand import CoilInHand
    from martensite.design.sizing.wire_in_hand import WireInHand

    kind = CoilInHand if coil else WireInHand
    missing = [
        f"`--{n}`" for n in ("diameter", "length", "supply") if given[n] is None and not (coil and n == "length")
    ]
    if missing:
        usual = '--coil --diameter "0.5 mm" --solid "25 mm" --resistance "3 ohm"' if coil else USUAL
        raise ParameterError(
            f'Option {", ".join(missing)} is needed; write for example `martensite wire {usual} --supply "5 V"`.'
        )
    units = {name: declared.unit for name, declared in kind.declarations.items()}
    values: dict[str, Any] = {n: read_quantity(n, t, units[n]) for n, t in given.items() if t is not None}
    return kind(**values, **chosen)
