"""The numbers of the claims: film coefficient, steady temperatures, the two closures."""

from __future__ import annotations

from typing import Any

from martensite.characterise.film_coefficient import fit_film
from martensite.characterise.regression import root_mean_square
from martensite.studies.tables import Printed
from martensite.studies.wire_heating import bench, closures


def compute_steady(printed: Printed) -> dict[str, Any]:
    """Return all numbers by the names of `claims.toml`."""
    films = [bench.printed_film(row, printed) for row in printed.rows]
    ambients = [bench.implied_ambient(row) for row in printed.rows]
    a, b = closures.closure_a(printed), closures.closure_b(printed)
    time_a, time_b = a.time_constant(printed), b.time_constant(printed)
    return {
        "films": [vars(row) | {"h": h} for row, h in zip(printed.rows, films, strict=True)],
        "ambient": bench.AMBIENT,
        "line": fit_film(printed.rows.column("temperature"), films, (0, 1)),
        "film_low": min(films),
        "film_high": max(films),
        "film_ambient": sum(ambients) / len(ambients),
        "ambient_low": min(ambients),
        "ambient_high": max(ambients),
        "measured_resistance": closures.measured_resistance(printed),
        "last_row": [vars(printed.rows[-1]) | {"textbook": bench.textbook_prandtl(printed.rows[-1])}],
        "steady": (steady := predict_steady(printed)),
        "hottest": [steady[len(steady) // 2 - 1], steady[-1]],
        "a": a,
        "b": b,
        "free": closures.closure_b_free(printed),
        "single": closures.closure_b_single(printed),
        "simulated": [
            {"key": key, "name": key.upper(), "rms": root_mean_square(simulated_errors(key, printed))}
            for key in bench.CLOSURES
        ],
        "time_a": time_a,
        "time_b": time_b,
        "time_constants": time_a / time_b,
    }


def predict_steady(printed: Printed) -> list[dict[str, Any]]:
    """Return the steady temperatures from the printed data, for both readings of the resistance."""
    as_printed = [closures.printed_resistance(row.voltage, printed) for row in printed.rows]
    per_metre = closures.read_per_metre(printed)
    measured = printed.rows.column("temperature")
    readings = (
        ("as-printed", "13 and 15 ohm", closures.predict_temperatures(printed, as_printed)),
        ("per-metre", "1.3 and 1.5 ohm", closures.predict_temperatures(printed, per_metre)),
    )
    return [
        {
            "reading": reading,
            "words": words,
            "voltage": row.voltage,
            "measured": row.temperature,
            "temperature": at,
            "span": temperatures[-1] - temperatures[0],
            "measured_span": measured[-1] - measured[0],
        }
        for reading, words, temperatures in readings
        for row, at in zip(printed.rows, temperatures, strict=True)
    ]


def simulated_errors(closure: str, printed: Printed) -> list[float]:
    """Return the simulated less printed steady temperatures of a closure's scenario [K]."""
    return [bench.simulated_temperature(closure, row.voltage) - row.temperature for row in printed.rows]
