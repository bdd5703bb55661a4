"""Limits of an element: warnings and stops of a run."""

from martensite.base.parameters import Number, Parametrised, param

MELTING = 1583.15
"""Temperature [K] at which NiTi melts (1310 degC, binary alloys of 50 at. %)."""
STRONGEST = 3e9
"""Stress [Pa] above the strength of any NiTi wire."""
LONGEST = 0.2
"""Strain [-] of a straight wire at which it has torn, or no law is valid."""


class ElementLimits(Parametrised):
    """Limits of warnings (infinite if unknown) and stops of a run."""

    temperature_limit: Number = param("K", "highest temperature without damage", above=0.0, default=float("inf"))
    stress_limit: Number = param("Pa", "highest stress for long life", above=0.0, default=float("inf"))
    strain_limit: Number = param("1", "largest strain amplitude for long life", above=0.0, default=float("inf"))
    temperature_stop: Number = param(
        "K", "temperature at which a run stops; at most where NiTi melts", above=0.0, high=MELTING, default=MELTING
    )
    stress_stop: Number = param("Pa", "stress at which a run stops", above=0.0, high=STRONGEST, default=STRONGEST)
    strain_stop: Number = param(
        "1", "strain of a straight wire at which a run stops", above=0.0, high=LONGEST, default=LONGEST
    )
