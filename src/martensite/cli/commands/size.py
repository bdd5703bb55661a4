"""`size`: find wires for a force, a stroke and a rate."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Exit, Option

from martensite.base.errors import InputError, ParameterError, SolveError
from martensite.cli.app import app
from martensite.cli.options import Force, Json, SaveAnyway, Text, read_quantity
from martensite.cli.outputs import JudgedOptions, Outputs, Verdict
from martensite.cli.progress import show_progress

if TYPE_CHECKING:
    from martensite.design.sizing.candidates import Sizing
    from martensite.design.sizing.request import WireRequest


@app.command("size", rich_help_panel="Design")
def size(
    pull: Annotated[Text, Option(help='Force on the load at the end of the stroke, e.g. "8 N".')] = None,
    stroke: Annotated[Text, Option(help='Stroke, e.g. "5 mm".')] = None,
    rate: Annotated[Text, Option(help='Cycle rate, e.g. "0.5 Hz".')] = None,
    supply: Annotated[Text, Option(help='Supply voltage, e.g. "12 V".')] = None,
    ambient: Annotated[Text, Option(help="Temperature of the still air [default: 22 degC].")] = None,
    strain: Annotated[Text, Option(help="Maximum strain [default: 4 %].")] = None,
    stress: Annotated[Text, Option(help="Maximum stress [default: 172 MPa].")] = None,
    life: Annotated[Text, Option(help="Number of cycles, e.g. 1e5, within the range of the published source.")] = None,
    element: Annotated[Text, Option(help="Element: wire, or coil (a spring of wire) [default: wire].")] = None,
    bias: Annotated[Text, Option(help="Return element: spring or weight [default: spring].")] = None,
    current_limit: Annotated[Text, Option(help='Maximum current of the supply, e.g. "3 A".')] = None,
    alloy: Annotated[str, Option(help="Alloy by transition temperature: 70, 90, or any.")] = "any",
    strands: Annotated[int | None, Option(help="Maximum number of parallel wires [default: 12].")] = None,
    no_limits: Annotated[
        bool, Option("--no-limits", help="Warn about the limits of the material instead of rejecting wires.")
    ] = False,
    every: Annotated[bool, Option("--all", help="List all candidates, with the reasons for rejection.")] = (False),
    catalogue: Annotated[
        bool, Option("--catalogue", help="Compare the model with the maker's table, without a request.")
    ] = False,
    pick: Annotated[int | None, Option(help="Number of the wire to describe and write [default: the best].")] = None,
    out: Annotated[Path | None, Option(help="Scenario file to write: .toml.")] = None,
    save_anyway: SaveAnyway = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Select a wire or coil for a force, stroke and rate.

    The exit code is 1 if no wire meets the request or the picked wire does not. Use --save-anyway to write such a
    wire.
    """
    given = {
        "pull": pull,
        "stroke": stroke,
        "rate": rate,
        "supply": supply,
        "ambient": ambient,
        "strain": strain,
        "stress": stress,
        "life": life,
        "current_limit": current_limit,
    }
    chosen = {"element": element, "bias": bias, "strands": strands, "limits": "ignore" if no_limits else None}
    if catalogue:
        chosen |= {"limits": None, "no_limits": no_limits or None}
        unused = {**given, **chosen, "out": out, "pick": pick, "all": every or None, "save_anyway": save_anyway or None}
        _refuse_idle({n: v for n, v in unused.items() if n not in ("stress", "ambient")})
        _check_catalogue(stress, ambient, alloy, json)
        return
    options = JudgedOptions(None, force, json, save_anyway)
    outputs = options.check_files(out, ".toml")
    request = _read_request(given, {"alloy": alloy, **chosen})
    with show_progress("simulating wires") as progress:
        from martensite.design.sizing.candidates import size_wire
        from martensite.design.sizing.scenario import format_scenario
        from martensite.physics.materials.wires import load_wires

        sizing = size_wire(request, progress=progress)
    from martensite.show.summaries.sizing import summarise_sizing, write_count

    best = _choose_candidate(sizing, pick)
    if best is None:
        Outputs(None, None).answer(summarise_sizing(sizing, best, every=every), json)
        raise SolveError("No wire meets the request" + ("." if out is None else f", so `{out}` was not written."))
    picked = sizing.candidates[best]
    verdict = write_count(sizing)
    if not picked.feasible:
        verdict = f"Wire {best + 1} does not meet the request: {picked.reasons[0]}"
    refused = outputs.answer_verdict(
        Verdict(not picked.feasible, verdict),
        summarise_sizing(sizing, best, every=every),
        options,
        lambda: format_scenario(sizing.request, picked, load_wires()),
    )
    if refused:
        raise Exit(1)


def _read_request(given: dict[str, Text], chosen: dict[str, Any]) -> WireRequest:
    from martensite.design.sizing.request import WireRequest

    missing = [n for n in ("pull", "stroke", "rate", "supply") if given[n] is None]
    if missing:
        named = ", ".join(f"`--{name}`" for name in missing)
        raise ParameterError(
            f"Option {named} is needed; write for example "
            '`martensite size --pull "8 N" --stroke "5 mm" --rate "0.5 Hz" --supply "12 V"`.'
        )
    units = {name: declared.unit for name, declared in WireRequest.declarations.items()} | {"pull": "N"}
    numbers: dict[str, Any] = {n: read_quantity(n, t, units[n]) for n, t in given.items() if t is not None}
    numbers["force"] = numbers.pop("pull")
    return WireRequest(**numbers, **{n: v for n, v in chosen.items() if v is not None})


def _refuse_idle(options: dict[str, Any]) -> None:
    named = next((name for name, value in options.items() if value is not None), None)
    if named is not None:
        raise InputError(f"Option `--{named.replace('_', '-')}` has no effect with --catalogue.")


def _choose_candidate(sizing: Sizing, pick: int | None) -> int | None:
    if pick is None:
        return 0 if sizing.best else None
    if not 1 <= pick <= len(sizing.candidates):
        raise InputError(f"Option `--pick` must be between 1 and {len(sizing.candidates)}, but is {pick}.")
    return pick - 1


def _check_catalogue(stress: Text, ambient: Text, alloy: str, json: bool) -> None:
    from martensite.design.sizing.catalogue_check import AMBIENT, STRESS, check_catalogue
    from martensite.design.sizing.request import ALLOYS, WireRequest
    from martensite.show.summaries.sizing import summarise_check
    from martensite.show.terminal import print_summary

    WireRequest.declarations["alloy"].convert("size", "alloy", alloy)
    alloys = ALLOYS if alloy == "any" else (alloy,)
    load = STRESS if stress is None else read_quantity("stress", stress, "Pa")
    room = AMBIENT if ambient is None else read_quantity("ambient", ambient, "K")
    with show_progress("simulating wires") as progress:
        rows = check_catalogue(alloys=alloys, stress=load, ambient=room, progress=progress)
    print_summary(summarise_check(rows, load, room), json)
