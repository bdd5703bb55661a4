"""`wire`: what a piece of wire at hand needs, and what it does."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from martensite.base.errors import ParameterError
from martensite.cli.app import app
from martensite.cli.options import FigureFile, Force, Json, Text, read_quantity
from martensite.cli.outputs import Outputs
from martensite.cli.progress import show_spinner


@app.command()
def wire(
    diameter: Annotated[Text, Option(help='Of the wire, e.g. "0.1 mm".')] = None,
    length: Annotated[Text, Option(help='Of the wire, e.g. "10 cm".')] = None,
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
    figure: FigureFile = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Say which current, resistor or duty a wire needs, and what it does.

    Exits with 1 where the supply cannot make it contract, or it does not come back.
    """
    from martensite.design.sizing.wire_ratings import WireInHand, rate_wire

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
    missing = [f"`--{name}`" for name in ("diameter", "length", "supply") if given[name] is None]
    if missing:
        raise ParameterError(
            f"Option {', '.join(missing)} is needed; write for example "
            '`martensite wire --diameter "0.1 mm" --length "10 cm" --supply "5 V"`.'
        )
    outputs = Outputs(None, figure).check(force)
    units = {name: declared.unit for name, declared in WireInHand.declarations.items()}
    numbers = {n: read_quantity(n.replace("_", "-"), t, units[n]) for n, t in given.items() if t is not None}
    with show_spinner("simulating the wire"):
        found = rate_wire(WireInHand(**numbers, alloy=alloy, cooling=cooling))
    from martensite.show.figures.circuit import plot_circuit
    from martensite.show.summaries.sizing import summarise_ratings

    outputs.answer(summarise_ratings(found), json, draw=lambda: plot_circuit(found))
    if found.faults:
        from typer import Exit

        raise Exit(1)
