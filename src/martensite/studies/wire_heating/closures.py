"""Two closures that make Table 2 agree with the heat balance, each fitted to all nine rows.

Closure A keeps the correlation for h and fits one effective resistance R:

    V²/R = h(T) S (T - T_a),    R and T_a fitted.

Closure B keeps resistances near 1.3 and 1.5 ohm and fits one effective h:

    T = T_a + V²/(R S h),    h fitted; T_a given or fitted.

The choice is arbitrary: a temperature over time, which could decide, is not printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from martensite.characterise.regression import fit_powers, fit_residuals, root_mean_square
from martensite.studies.tables import Printed
from martensite.studies.wire_heating import bench

PER_METRE = 0.1
"""Length [m] that converts the printed ohms, read as ohms per metre, to the wire."""
DENSITY, HEAT_CAPACITY = 6450.0, 837.0
"""Values of the maker's sheet [kg/m³], [J/(kg K)]; the thesis prints neither."""


@dataclass(frozen=True)
class Closure:
    """A fitted closure."""

    resistance: float | None
    """Effective resistance [ohm]; None if it changes with the voltage."""
    h: float
    """Effective film coefficient [W/(m² K)], or the mean of the correlation over the rows."""
    ambient: float
    """Ambient temperature [°C]."""
    errors: tuple[float, ...]
    """Computed less printed temperatures of the rows [K]."""

    @property
    def rms(self) -> float:
        """Return the root mean square of the errors [K]."""
        return root_mean_square(self.errors)

    def time_constant(self, printed: Printed) -> float:
        """Return m c/(h S) without transformation [s]."""
        return DENSITY * HEAT_CAPACITY * printed.diameter / (4.0 * self.h)


@cache
def closure_a(printed: Printed) -> Closure:
    """Return the closure with h of the correlation; resistance and ambient fitted."""

    def errors(values: tuple[float, ...]) -> list[float]:
        ohms, ambient = values
        return [
            bench.steady_temperature(row.voltage**2 / ohms, ambient, printed) - row.temperature for row in printed.rows
        ]

    fit = fit_residuals(errors, (4.0, bench.AMBIENT))
    ohms, ambient = fit.values
    films = [bench.film_coefficient(row.temperature, ambient, printed) for row in printed.rows]
    return Closure(ohms, sum(films) / len(films), ambient, fit.residuals)


def printed_resistance(voltage: float, printed: Printed) -> float:
    """Return the printed resistance at a voltage [V], in ohm."""
    austenite = voltage > printed.austenite_from - 1e-9
    return printed.resistance_A if austenite else printed.resistance_M


def read_per_metre(printed: Printed) -> list[float]:
    """Return the resistances of the rows, with the printed ones read as ohms per metre [ohm]."""
    return [PER_METRE * printed_resistance(volts, printed) for volts in printed.rows.column("voltage")]


def measured_resistance(printed: Printed) -> float:
    """Return voltage over current where the thesis gives both [ohm]."""
    return printed.current_at / printed.current


@cache
def closure_b(printed: Printed, ambient: float = bench.AMBIENT) -> Closure:
    """Return the closure with resistances per metre; h fitted for an ambient temperature [°C]."""
    rises = _list_rises(printed, read_per_metre(printed))
    over = [at - ambient for at in printed.rows.column("temperature")]
    pairs = list(zip(rises, over, strict=True))
    h = sum(x * x for x, _ in pairs) / sum(x * y for x, y in pairs)
    return Closure(None, h, ambient, tuple(x / h - y for x, y in pairs))


@cache
def closure_b_free(printed: Printed) -> Closure:
    """Return the closure with resistances per metre; h and ambient fitted."""
    return _fit_line(printed, read_per_metre(printed), None)


@cache
def closure_b_single(printed: Printed) -> Closure:
    """Return the closure with the measured resistance for all rows; h and ambient fitted."""
    ohms = measured_resistance(printed)
    return _fit_line(printed, [ohms] * len(printed.rows), ohms)


def _list_rises(printed: Printed, resistances: Sequence[float]) -> list[float]:
    """Return V²/(R S) of the rows [W/m²]."""
    pairs = zip(printed.rows.column("voltage"), resistances, strict=True)
    return [volts * volts / (ohms * bench.lateral_surface(printed)) for volts, ohms in pairs]


def _fit_line(printed: Printed, resistances: Sequence[float], single: float | None) -> Closure:
    """Return the fit of T = T_a + x/h by linear least squares."""
    rises = _list_rises(printed, resistances)
    line = fit_powers(rises, printed.rows.column("temperature"), (0, 1))
    ambient, slope = line.values
    errors = tuple(line.value(x) - at for x, at in zip(rises, printed.rows.column("temperature"), strict=True))
    return Closure(single, 1.0 / slope, ambient, errors)


def predict_temperatures(printed: Printed, resistances: Sequence[float]) -> list[float]:
    """Return the steady temperatures of the rows with the correlation and given resistances [°C]."""
    return [
        bench.steady_temperature(row.voltage**2 / ohms, bench.AMBIENT, printed)
        for row, ohms in zip(printed.rows, resistances, strict=True)
    ]
