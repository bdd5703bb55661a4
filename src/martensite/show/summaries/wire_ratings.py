"""Ratings of a given wire or coil: verdict, drive, cycle, and electronics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from martensite.base.formats import write_percent
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.design.sizing.remarks import COIL_DOUBT, describe_life
from martensite.design.sizing.wire_ratings import TOUCHABLE, WireRatings
from martensite.show.summaries.sizing import describe_coil

DRIVES = ("", "current\nA", "voltage\nV", "series\nresistor\nΩ", "power in\nresistor\nW", "PWM duty\ncycle\n%")


def summarise_ratings(ratings: WireRatings) -> Summary:
    """Return the summary of a wire."""
    return Summary(
        "", [*_tell_verdict(ratings), *_describe_wire(ratings), *_describe_parts(ratings)], ratings.to_dict()
    )


def _tell_verdict(ratings: WireRatings) -> Iterator[Block]:
    coil = " of wire in a coil" if ratings.describe_coil() else ""
    length = f"{1e3 * ratings.strand.length:.4g} mm{coil}"
    name = f"Flexinol {ratings.size.name}, {ratings.wire.alloy} °C, {length}, {ratings.strand.resistance:.3g} Ω"
    if ratings.faults:
        yield Sentence(f"{name}: DOES NOT WORK.", "bad")
    elif ratings.cycle is not None:
        yield Sentence(f"{name}: contracts in {ratings.wire.pulse:.3g} s at {ratings.cycle.current:.3g} A.", "good")
    yield from (Sentence(f"Reason: {fault}.", "bad") for fault in ratings.faults)
    yield from (Sentence(f"WARNING: {caution}.", "bad") for caution in ratings.cautions)


def _describe_wire(ratings: WireRatings) -> Iterator[Block]:
    wire, size, cycle = ratings.wire, ratings.size, ratings.cycle
    coil, most = ratings.describe_coil(), ratings.stress_limit
    share = "" if coil else f" ({write_percent(ratings.stroke / wire.length, 2)} of the length)"
    yield Sentence(
        f"Force {ratings.hot_force:.3g} N at {ratings.hot_stress / 1e6:.4g} MPa "
        f"(limit {most * ratings.strand.bearing:.3g} N at {most / 1e6:.4g} MPa), "
        f"stroke {1e3 * ratings.stroke:.3g} mm{share}."
    )
    if coil is not None:
        yield from _describe_shape(ratings, coil)
    rows = [_drive_row(ratings, f"contract in {wire.pulse:.3g} s", cycle.current)] if cycle is not None else []
    rows.append(_drive_row(ratings, "hold contracted", ratings.holding_current))
    rows.append(_drive_row(ratings, "maximum continuous", ratings.most_current))
    yield DataTable(DRIVES, rows, right=range(1, len(DRIVES)))
    yield Sentence(f"Series resistor and PWM duty cycle are for a supply of {wire.supply:.3g} V.")
    if cycle is not None and cycle.cooling is not None:
        yield Sentence(
            f"Cycle: contracts in {cycle.heating:.3g} s, cools in {cycle.cooling:.3g} s, at most "
            f"{1.0 / (cycle.heating + cycle.cooling):.2g} Hz, {ratings.energy:.3g} J per cycle, "
            f"up to {cycle.hottest - 273.15:.0f} °C."
        )
    if cycle is not None and wire.pulse == 1.0 and wire.cooling == "air" and coil is None:
        table = size.current.value
        yield Sentence(
            f"The maker's table gives {1e3 * table:.4g} mA for 1 s; the model needs {cycle.current / table:.2f} times "
            "that current."
        )
    yield Sentence(f"Life: {describe_life(ratings.hot_stress, 'coil' if coil else 'wire')}.")


def _describe_shape(ratings: WireRatings, coil: Mapping[str, float]) -> Iterator[Block]:
    state = ratings.drawn_coil
    yield Sentence(f"Coil: {describe_coil(coil)}.")
    if state is not None:
        pulls = f"the coil pulls {state.hot_force:.3g} N ({state.hot_stress / 1e6:.4g} MPa)"
        if state.hot_stress > ratings.stress_limit:
            pulls += f", above the maker's {ratings.stress_limit / 1e6:.4g} MPa: use a load instead"
        yield Sentence(
            f"Stretched to {1e3 * state.length:.4g} mm, the wire has a shear strain of {write_percent(state.shear, 2)} "
            f"(equivalent strain {write_percent(state.strain, 2)}). If it is held there and heated, {pulls}."
        )
    yield Sentence(COIL_DOUBT, "caution")


def _drive_row(ratings: WireRatings, name: str, current: float) -> tuple[str, ...]:
    series, power = ratings.series_resistor(current)
    duty = ratings.duty(current)
    parts = (f"{series:.3g}", f"{power:.2g}", f"{100.0 * duty:.2g}") if duty <= 1.0 else ("supply too low", "", "")
    return (name, f"{current:.3g}", f"{current * ratings.strand.resistance:.3g}", *parts)


def _describe_parts(ratings: WireRatings) -> Iterator[Block]:
    wire, ohms = ratings.wire, ratings.strand.resistance
    full, stored = ratings.full_current, 0.5 * ratings.inductance * ratings.full_current**2
    hot = full > ratings.most_current
    yield Sentence(
        f"{'WARNING: d' if hot else 'D'}irectly on {wire.supply:.3g} V the wire draws {full:.3g} A, "
        f"{full / ratings.most_current:.2g} times its continuous rating ({ratings.most_current:.3g} A). "
        + ("Use timed pulses only." if hot else "It can stay on."),
        "caution" if hot else "",
    )
    if wire.supply > TOUCHABLE:
        return
    yield Sentence(
        f"Switch: logic-level N-channel MOSFET, at least {2.0 * wire.supply:.3g} V and {2.0 * full:.2g} A, "
        f"on-resistance at most {0.05 * ohms:.2g} Ω ({0.05 * ohms * full**2:.2g} W). A controller pin gives only 20 mA."
    )
    yield Sentence(
        f"Flyback diode: not needed for {1e6 * ratings.inductance:.2g} µH and {1e6 * stored:.2g} µJ. A motor or relay "
        "on the same supply needs one."
    )
    if ratings.count:
        yield Sentence(f"A supply of {wire.current_limit:.3g} A drives {ratings.count} in parallel.")
