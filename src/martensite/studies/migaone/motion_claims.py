"""Claims on motion: the response to the sine, and the actuation time.

The figures of the paper are not in the text at hand and its amplitude is not stated, so the
sine can be reported but not checked.
"""

from __future__ import annotations

from martensite.studies.base import Claim
from martensite.studies.migaone import bench
from martensite.studies.migaone.printed import PAPER, Printed

SINE = f"{PAPER}, section 5, Figures 7 and 8"
QUICK = f"{PAPER}, section 4.1"
ROOM = 25.0
"""Ambient temperature of the range of actuation times [°C]."""
ALLOWED = 0.7
"""Difference of the actuation time that still counts as "about 1 s" [s]."""
TABLED_70 = {"A_s": 68.0, "A_f": 78.0, "M_s": 52.0, "M_f": 42.0}
"""Transition temperatures of a 70 °C wire in the maker's table [°C]."""


def claims(printed: Printed) -> list[Claim]:
    """The sine first, then the actuation time."""
    return [*_sine(printed), *_quick(printed)]


def _sine(printed: Printed) -> list[Claim]:
    found = {key: bench.response(key, printed) for key in bench.VARIANTS}
    return [
        *(
            claim
            for key, response in found.items()
            for claim in _response(key, response)
        ),
        Claim.reported(
            "sine-late-return", "sine: later return with latent heat and the maker's heat capacity",
            SINE, found["polynomial"].fall - found["paper"].fall, "s",
            "sign of the mismatch on cooling that the paper admits and leaves to further work",
        ),
        Claim.reported(
            "sine-early-return", "sine: earlier return if equation (6) serves cooling too",
            SINE, found["paper"].fall - found["one-curve"].fall, "s",
            "equation (6) has no martensite temperatures: a second branch is needed",
        ),
    ]  # fmt: skip


def _response(key: str, response: bench.Response) -> list[Claim]:
    why = f"{bench.VARIANTS[key]}; 0 to 2.5 V is assumed, and the figures are not at hand"
    rows = [
        ("hottest", "highest temperature", response.hottest, "degC"),
        ("rise", "half of 8 mm reached on heating", response.rise, "s"),
        ("fall", "half of 8 mm passed on cooling", response.fall, "s"),
        ("stroke", "stroke", 1e3 * response.stroke, "mm"),
    ]
    return [
        Claim.reported(f"sine-{key}-{name}", f"sine, {key}: {statement}", SINE, value, unit, why)
        for name, statement, value, unit in rows
    ]


def fastest(printed: Printed) -> float:
    """Actuation time of a 70 °C wire at its tabled temperatures, with the paper's heat [s]."""
    stress = bench.number("mass") * bench.number("gravity") / bench.base_wire().section()
    shift = stress / bench.number("C_A")
    at_zero_stress = {name: t + bench.ZERO - shift for name, t in TABLED_70.items()}
    values = {**at_zero_stress, "heat_capacity": printed.heat_capacity, "latent_heat": 0.0}
    return bench.actuation_time(printed, ROOM, tuple(values.items()))


def slowest(printed: Printed) -> float:
    """Actuation time of this study's wire at room temperature [s]."""
    return bench.actuation_time(printed, ROOM)


def thin(printed: Printed, ambient: float) -> float:
    """Actuation time of the wire that Table 1 describes, at the same stress [s]."""
    ratio = printed.diameter / bench.base_wire().diameter
    values = (("diameter", printed.diameter), ("mass", bench.number("mass") * ratio**2))
    return bench.actuation_time(printed, ambient, values, duration=0.05)


def _quick(printed: Printed) -> list[Claim]:
    here, statement = printed.ambient, "actuation time at 5 V"
    return [
        Claim.checked(
            "actuation-time", f"{statement} of about 1 s", QUICK,
            printed.actuation_time, bench.actuation_time(printed, here), "s", ALLOWED,
            f"to 95 % of the stroke, 2.7 ohm, {here:g} °C; the tolerance is what alloy, heat "
            "capacity and ambient temperature leave open, none of which is stated",
        ),
        Claim.reported(
            "actuation-time-fastest", f"{statement}, fastest of the assumptions", QUICK,
            fastest(printed), "s",
            f"70 °C wire at its tabled temperatures, 320 J/(kg K), no latent heat, {ROOM:g} °C",
        ),
        Claim.reported(
            "actuation-time-slowest", f"{statement}, slowest of the assumptions", QUICK,
            slowest(printed), "s",
            f"90 °C wire corrected to the stress, 837 J/(kg K), latent heat, {ROOM:g} °C",
        ),
        Claim.reported(
            "actuation-time-thin", f"{statement}, with the diameter of Table 1", QUICK,
            thin(printed, here), "s",
            "a wire of 0.038 mm holds a hundredth of the heat: one more sign that Table 1 is "
            "misprinted",
        ),
    ]  # fmt: skip
