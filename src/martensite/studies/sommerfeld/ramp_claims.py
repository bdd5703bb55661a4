"""Claims on the measured ramps: what they imply, and the calibrated motor without the wire."""

from __future__ import annotations

from martensite.mechanisms.beam_motor import BeamMotor
from martensite.studies.base import Claim
from martensite.studies.sommerfeld import averages, beam_claims, machines, runs, wire
from martensite.studies.sommerfeld.printed import THESIS, Printed
from martensite.studies.sommerfeld.runs import Windows

FIGURE_34, FIGURE_37 = f"{THESIS}, Figure 34", f"{THESIS}, Figure 37"
COMPARED = f"{THESIS}, section 5.2.2"
RATES = (0.1, 0.5, 1.0)
"""Other rates of the ramp [V/s]."""
LAST = 12.0
"""End of the ramps with changed stiffness or damping [V]."""


def claims(printed: Printed) -> list[Claim]:
    """Table 3 in a ramp, calibration, rates, what the change requires."""
    return [
        *_uncalibrated(printed), *_calibration(printed), *_ramp(printed), *_numbers(printed),
        *_required(printed),
    ]  # fmt: skip


def _uncalibrated(printed: Printed) -> list[Claim]:
    found = runs.upward(machines.printed_motor(printed), *beam_claims.UP)
    return [
        Claim.checked(
            "ramp-table-3", "jump in a slow ramp without the wire, Table 3", FIGURE_34,
            printed.jump, found.jump, "V", 0.3,
            f"{beam_claims.UP[0]:g} V/s; Table 3 describes neither this ramp nor its currents",
        )
    ]  # fmt: skip


def _calibration(printed: Printed) -> list[Claim]:
    found = averages.calibration(printed)
    rows = (
        ("mass", "moving mass", printed.mass, found.mass, "kg",
         f"M = k/ω², from the measured {printed.measured_frequency:g} Hz"),
        ("damping", "damping of the beam", printed.damping, found.damping, "N*s/m",
         f"c = m r ω/A, from the amplitude of {1e3 * printed.amplitude:g} mm"),
        ("resistance", "resistance of the motor", printed.resistance, found.resistance, "ohm",
         f"from the jump at {printed.jump:g} V; only R m r and c/(m r) follow from the data"),
    )  # fmt: skip
    return [
        Claim.calibrated(f"calibrated-{id}", words, FIGURE_34, value, number, unit, why)
        for id, words, value, number, unit, why in rows
    ]


def _ramp(printed: Printed) -> list[Claim]:
    found, why = wire.without(printed), f"calibrated set, {wire.RATE:g} V/s: the rate is assumed"
    motor = machines.calibrated_motor()
    return [
        Claim.calibrated(
            "ramp-jump", "jump without the wire", FIGURE_34, printed.jump, found.jump, "V", why
        ),
        Claim.calibrated(
            "ramp-amplitude", "peak amplitude without the wire", FIGURE_34,
            1e3 * printed.amplitude, 1e3 * found.peak, "mm", why,
        ),
        *(
            Claim.reported(
                f"ramp-rate-{rate:g}", f"jump without the wire at {rate:g} V/s", FIGURE_34,
                runs.upward(motor, rate, 8.0).jump, "V",
                "the thesis gives no rate; above 1 V/s the rotor passes by its inertia",
            )
            for rate in RATES
        ),
    ]  # fmt: skip


def _numbers(printed: Printed) -> list[Claim]:
    return [
        Claim.checked(
            "earlier", "the wire brings the jump forward by almost 2 V", COMPARED,
            printed.earlier, printed.jump - printed.jump_with_wire, "V", 0.3,
            "6.38 V less 5.2 V, both printed",
        ),
        Claim.checked(
            "amplitude-in-text", "peak amplitude without the wire, about 0.052 m", COMPARED,
            1e3 * printed.amplitude_in_text, float(whole_millimetres(printed)[0]), "mm", 1.0,
            "the only whole millimetres near it that give the printed 42.59 % of reduction, with "
            f"{whole_millimetres(printed)[1]} mm left",
        ),
        Claim.checked(
            "current-drop-table-3", "the motor's current falls by about 0.2 A", COMPARED,
            printed.current_drop,
            (printed.jump - printed.jump_with_wire) / printed.resistance, "A", 0.05,
            "most that the printed 41 ohm allow between the two jumps, at equal speed",
        ),
    ]  # fmt: skip


def whole_millimetres(printed: Printed) -> tuple[int, int]:
    """The amplitudes within 6 mm of that in the text that give the reduction, to its digits."""
    text, wanted = round(1e3 * printed.amplitude_in_text), round(100.0 * printed.reduction, 2)
    return next(
        (before, after)
        for before in range(text - 6, text + 7)
        for after in range(before)
        if round(100.0 * (1.0 - after / before), 2) == wanted
    )


def variants(printed: Printed) -> dict[str, Windows]:
    """Ramps with the stiffness, the damping, or both changed as the published numbers require."""
    base = machines.calibrated_motor()
    stiff, damped = averages.required(printed)
    more = {"stiffness": stiff * base.stiffness, "damping": damped * base.damping}
    changed: dict[str, BeamMotor] = {
        "stiffness": base.with_values({"stiffness": more["stiffness"]}),
        "damping": base.with_values({"damping": more["damping"]}),
        "both": base.with_values(more),
    }
    return {name: runs.upward(motor, wire.RATE, LAST) for name, motor in changed.items()}


def _required(printed: Printed) -> list[Claim]:
    stiff, damped = averages.required(printed)
    found = variants(printed)
    rows = (
        ("stiffness", f"{stiff:.2f} times the stiffness"),
        ("damping", f"{damped:.2f} times the damping"),
        ("both", "both"),
    )
    why = 'calibrated set in a ramp; "increases the stiffness" does not explain an earlier jump'
    return [
        Claim.reported(
            "required-stiffness", "factor of the stiffness that both ramps imply", FIGURE_37,
            stiff, "1", "(V₂ - K_B ω₂)/(V₁ - K_B ω₁) = ω₂² A₂/(ω₁² A₁), for any R",
        ),
        Claim.reported(
            "required-damping", "factor of the damping that both ramps imply", FIGURE_37,
            damped, "1", "c₂/c₁ = (ω₂/ω₁)(A₁/A₂): the wire must dissipate",
        ),
        *(
            Claim.reported(
                f"with-{name}", f"jump with {words}, no wire", FIGURE_37, found[name].jump, "V",
                why,
            )
            for name, words in rows
        ),
    ]  # fmt: skip
