"""The claims: film coefficient, resistances, steady temperatures, the two closures."""

from __future__ import annotations

from martensite.characterise.film_coefficient import fit_film
from martensite.characterise.nonlinear_regression import root_mean_square
from martensite.studies.base import Claim
from martensite.studies.wire_heating import bench, closures
from martensite.studies.wire_heating.printed import THESIS, Printed

TABLE_1, TABLE_2 = f"{THESIS}, Table 1", f"{THESIS}, Table 2"
FIGURE_15, FIGURE_16 = f"{THESIS}, Figure 15", f"{THESIS}, Figure 16"
CLOSE = 5.0
"""Largest error that "very close to the actual behavior" is taken to allow [K]."""
FILM, OHM = "W/m^2/K", "ohm"


def claims(printed: Printed) -> list[Claim]:
    """Every claim with its verdict."""
    return [*films(printed), *resistances(printed), *steady(printed), *fitted(printed)]


def films(printed: Printed) -> list[Claim]:
    """h of every row, and whether it is linear in the temperature."""
    found = [bench.printed_film(row, printed) for row in printed.rows]
    line = fit_film(printed.temperatures, found, (0, 1))
    ambients = [bench.implied_ambient(row) for row in printed.rows]
    return [
        *(
            Claim.reported(
                f"film-{row.voltage:.1f}V", f"film coefficient at {row.temperature:g} °C",
                FIGURE_15, h, FILM,
                "equations (3.2) to (3.4) with the properties of Table 2; the figure that shows "
                f"h is not in the text at hand, and the ambient is assumed: {bench.AMBIENT:g} °C",
            )
            for row, h in zip(printed.rows, found, strict=True)
        ),
        Claim.reported(
            "film-line", "R² of a straight line through h", FIGURE_15, line.r_squared, "1",
            f"\"a completely linear profile\": h = {line.coefficients[0]:.2f} + "
            f"{line.coefficients[1]:.4f} T, from {min(found):.1f} to {max(found):.1f} {FILM}",
        ),
        Claim.reported(
            "film-ambient", "ambient temperature that the printed conductivities imply", TABLE_2,
            sum(ambients) / len(ambients), "degC",
            f"mean of the rows, which scatter from {min(ambients):.1f} to {max(ambients):.1f} °C: "
            "2 T_f - T_s, with T_f where a textbook's air conducts as printed; stated nowhere",
        ),
    ]  # fmt: skip


def resistances(printed: Printed) -> list[Claim]:
    """The printed resistance against voltage over current."""
    ohms = closures.measured_resistance(printed)
    return [
        Claim.checked(
            "resistance", "resistance of the wire is 13 ohm (austenite) or 15 ohm", TABLE_1,
            printed.resistance_A, ohms, OHM, printed.resistance_M - printed.resistance_A,
            f"{printed.current_at:g} V and {printed.current:g} A of section 3.2.2; read as ohms "
            f"per metre, the wire of {printed.length:g} m has 1.3 and 1.5 ohm",
        )
    ]  # fmt: skip


def steady(printed: Printed) -> list[Claim]:
    """Steady temperatures from the printed data, for both readings of the resistance."""
    as_printed = [printed.resistance(volts) for volts in printed.voltages]
    readings = (
        ("as-printed", "13 and 15 ohm", as_printed),
        ("per-metre", "1.3 and 1.5 ohm", closures.read_per_metre(printed)),
    )
    made: list[Claim] = []
    for id, words, ohms in readings:
        found = closures.predicted(printed, ohms)
        span = found[-1] - found[0]
        measured = printed.temperatures[-1] - printed.temperatures[0]
        made += [
            Claim.checked(
                f"steady-{id}-{row.voltage:.1f}V",
                f"steady temperature at {row.voltage:.1f} V with {words}",
                FIGURE_16, row.temperature, at, "degC", CLOSE,
                "V²/R = h S (T - T_a) with h of (3.2); no other ambient mends it: from first row "
                f"to last it rises by {span:.0f} K, in Table 2 by {measured:.0f} K",
            )
            for row, at in zip(printed.rows, found, strict=True)
        ]  # fmt: skip
    return made


def fitted(printed: Printed) -> list[Claim]:
    """The closures, and what they leave undecided."""
    a, b = closures.closure_a(printed), closures.closure_b(printed)
    free, single = closures.closure_b_free(printed), closures.closure_b_single(printed)
    rows = [
        ("a-resistance", "closure A: effective resistance", a.resistance or 0.0, OHM,
         "h from the correlation; resistance and ambient fitted to the nine rows"),
        ("a-ambient", "closure A: ambient temperature", a.ambient, "degC", "fitted with it"),
        ("a-rms", "closure A: rms error of the nine temperatures", a.rms, "K", "of that fit"),
        ("b-film", "closure B: effective film coefficient", b.h, FILM,
         f"1.3 and 1.5 ohm, ambient held at {b.ambient:g} °C; h fitted to the nine rows"),
        ("b-rms", "closure B: rms error of the nine temperatures", b.rms, "K", "of that fit"),
        ("b-free-film", "closure B, ambient fitted too: film coefficient", free.h, FILM,
         f"the best ambient would be {free.ambient:.1f} °C, warmer than a room"),
        ("b-free-rms", "closure B, ambient fitted too: rms error", free.rms, "K", "of that fit"),
        ("b-single-film", "closure B, one resistance: film coefficient", single.h, FILM,
         f"{closures.measured_resistance(printed):.3f} ohm throughout; the ambient is fitted, "
         f"{single.ambient:.1f} °C"),
        ("b-single-rms", "closure B, one resistance: rms error", single.rms, "K", "of that fit"),
    ]  # fmt: skip
    return [
        *(
            Claim.calibrated(f"closure-{id}", words, TABLE_2, None, number, unit, why)
            for id, words, number, unit, why in rows
        ),
        *(
            Claim.calibrated(
                f"closure-{key}-simulated", f"closure {key.upper()} simulated: rms error", TABLE_2,
                None, simulated_rms(key, printed), "K",
                f"nine runs of the scenario closure-{key}.toml, numbers rounded, alloy assumed",
            )
            for key in bench.CLOSURES
        ),
        Claim.reported(
            "time-constants", "time constant of closure A over that of closure B", FIGURE_16,
            a.time_constant(printed) / b.time_constant(printed), "1",
            f"{a.time_constant(printed):.1f} s against {b.time_constant(printed):.1f} s; the text "
            "at hand holds no temperature over time that could decide",
        ),
    ]  # fmt: skip


def simulated_errors(closure: str, printed: Printed) -> list[float]:
    """Simulated less printed steady temperatures of a closure's scenario [K]."""
    return [
        bench.simulated_temperature(closure, row.voltage) - row.temperature for row in printed.rows
    ]


def simulated_rms(closure: str, printed: Printed) -> float:
    """Root mean square of `simulated_errors` [K]."""
    return root_mean_square(simulated_errors(closure, printed))
