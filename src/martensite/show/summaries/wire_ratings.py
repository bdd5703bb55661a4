"""A wire or a coil at hand: the verdict, what drives it, and the parts around it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from martensite.base.formats import write_percent
from martensite.base.summary import Block, DataTable, Heading, Sentence, Summary
from martensite.design.sizing.remarks import COIL_DOUBT, describe_life
from martensite.design.sizing.wire_ratings import TOUCHABLE, WireRatings
from martensite.show.summaries.sizing import describe_coil

DRIVES = ("", "current\nA", "at the wire\nV", "or in series\nohm", "which takes\nW", "or duty\n%")


def summarise_ratings(found: WireRatings) -> Summary:
    """Return everything about a piece of wire: pull, drive, times, the parts that it needs."""
    return Summary("", [*_tell_verdict(found), *_describe_wire(found), *_describe_parts(found)], found.to_dict())


def _tell_verdict(found: WireRatings) -> Iterator[Block]:
    if found.cycle is not None and not found.faults:
        yield Sentence(f"Does: {found.cycle.current:.3g} A contract it in {found.wire.pulse:.3g} s.", "good")
    yield from (Sentence(f"Does not do: {fault}.", "bad") for fault in found.faults)
    yield from (Sentence(f"Warning: {caution}.", "bad") for caution in found.cautions)


def _describe_wire(found: WireRatings) -> Iterator[Block]:
    wire, size, cycle = found.wire, found.size, found.cycle
    coil, maker = found.describe_coil(), found.stress_limit / 1e6
    length = f"{1e3 * found.strand.length:.4g} mm" + (" of wire in a coil" if coil else "")
    yield Heading(f"Flexinol {size.name}, {wire.alloy} °C, {length}, {found.strand.resistance:.3g} ohm")
    if coil is not None:
        yield from _describe_shape(found, coil)
    share = "" if coil else f", {write_percent(found.stroke / wire.length, 2)} of its length"
    yield Sentence(
        f"Pulls {found.hot_force:.3g} N ({found.hot_stress / 1e6:.4g} MPa; the maker's {maker:.4g} MPa are "
        f"{found.stress_limit * found.strand.bearing:.3g} N) over {1e3 * found.stroke:.3g} mm{share}."
    )
    rows = [_drive_row(found, f"contract in {wire.pulse:.3g} s", cycle.current)] if cycle is not None else []
    rows.append(_drive_row(found, "hold contracted", found.holding_current))
    rows.append(_drive_row(found, "most, continuous", found.most_current))
    yield DataTable(DRIVES, rows, right=range(1, len(DRIVES)))
    if cycle is not None and cycle.cooling is not None:
        yield Sentence(
            f"Contracts in {cycle.heating:.3g} s and comes back in {cycle.cooling:.3g} s: at most "
            f"{1.0 / (cycle.heating + cycle.cooling):.2g} cycles a second, {found.energy:.3g} J each, "
            f"at up to {cycle.hottest - 273.15:.0f} °C."
        )
    if cycle is not None and wire.pulse == 1.0 and wire.cooling == "air" and coil is None:
        table = size.current.value
        yield Sentence(
            f"The maker's table has {1e3 * table:.4g} mA for 1 s; the model's current is {cycle.current / table:.2f} "
            "of it. With more a wire contracts faster, and must be switched off in time."
        )
    yield Sentence(f"Life: {describe_life(found.hot_stress, 'coil' if coil else 'wire')}.")


def _describe_shape(found: WireRatings, coil: Mapping[str, float]) -> Iterator[Block]:
    drawn = found.drawn
    yield Sentence(f"It has {describe_coil(coil)}.")
    if drawn is not None:
        pulls = f"it pulls {drawn.hot_force:.3g} N ({drawn.hot_stress / 1e6:.4g} MPa)"
        if drawn.hot_stress > found.stress_limit:
            pulls = f"it has more than the maker's {found.stress_limit / 1e6:.4g} MPa: give it a load instead"
        yield Sentence(
            f"Drawn out to {1e3 * drawn.length:.4g} mm its wire is sheared by {write_percent(drawn.shear, 2)} (a "
            f"strain of {write_percent(drawn.strain, 2)}); held there and heated {pulls}."
        )
    yield Sentence(COIL_DOUBT, "caution")


def _drive_row(found: WireRatings, name: str, current: float) -> tuple[str, ...]:
    series, power = found.series_resistor(current)
    duty = found.duty(current)
    parts = (f"{series:.3g}", f"{power:.2g}", f"{100.0 * duty:.2g}") if duty <= 1.0 else ("too little supply", "", "")
    return (name, f"{current:.3g}", f"{current * found.strand.resistance:.3g}", *parts)


def _describe_parts(found: WireRatings) -> Iterator[Block]:
    wire, ohms = found.wire, found.strand.resistance
    full, stored = found.full_current, 0.5 * found.inductance * found.full_current**2
    yield Heading("Around it")
    yield Sentence(
        f"Directly on {wire.supply:.3g} V it draws {full:.3g} A, {full / found.most_current:.2g} times its continuous "
        f"rating ({found.most_current:.3g} A). "
        + ("Use timed pulses only." if full > found.most_current else "It may stay on.")
    )
    if wire.supply > TOUCHABLE:
        return
    yield Sentence(
        f"Switch: a logic-level N-channel MOSFET for at least {2.0 * wire.supply:.3g} V and {2.0 * full:.2g} A, below "
        f"{0.05 * ohms:.2g} ohm when on ({0.05 * ohms * full**2:.2g} W at most); a pin of a controller gives 20 mA."
    )
    what = "This coil" if found.describe_coil() else "A straight wire"
    yield Sentence(
        f"{what} has {1e6 * found.inductance:.2g} µH and stores {1e6 * stored:.2g} µJ: it needs no flyback "
        "diode; a motor or relay beside it does."
    )
    if found.count:
        yield Sentence(f"A supply of {wire.current_limit:.3g} A drives {found.count} of them at once.")
