"""Claims on the wire: a fit of its slack on the beam, its control, and its own test bench.

The thesis gives neither length, slack, attachment nor alloy of the wire, nor the rate of the
ramp. Nothing here is a prediction.
"""

from __future__ import annotations

from martensite.studies.base import Claim
from martensite.studies.sommerfeld import actuator, machines, wire
from martensite.studies.sommerfeld.printed import THESIS, Printed

FIGURE_37, FIGURE_38 = f"{THESIS}, Figure 37", f"{THESIS}, Figure 38"
FIGURE_40, COMPARED = f"{THESIS}, Figure 40", f"{THESIS}, section 5.2.2"
BENCH = f"{THESIS}, section 3.2.2"


def claims(printed: Printed) -> list[Claim]:
    """The fit, what follows from it, the control signal, the actuator alone."""
    return [*_fit(printed), *_follows(printed), *_control(printed), *_actuator(printed)]


def _fit(printed: Printed) -> list[Claim]:
    best = wire.best(printed)
    by_jump = wire.slack_for(printed, "jump", printed.jump_with_wire)
    by_size = wire.slack_for(printed, "reduction", printed.reduction)
    tried = ", ".join(f"{100 * slack:g}" for slack in wire.SLACKS)
    why = f"slack of {100 * best.slack:g} %, the best of {tried} %: a fit to this very number"
    return [
        Claim.calibrated(
            "wire-slack", "slack of the hot wire", FIGURE_37, None, 100.0 * best.slack, "%",
            f"the jump voltage alone asks for {100 * by_jump:.2f} %, the reduction alone for "
            f"{100 * by_size:.2f} %: one number meets both",
        ),
        Claim.calibrated(
            "wire-jump", "jump with the wire", FIGURE_37, printed.jump_with_wire, best.jump, "V",
            why,
        ),
        Claim.calibrated(
            "wire-reduction", "peak amplitude less than without the wire", COMPARED,
            100.0 * printed.reduction, 100.0 * best.reduction, "%", why,
        ),
        *(
            Claim.reported(
                f"wire-jump-{100 * one.slack:g}%", f"jump with a slack of {100 * one.slack:g} %",
                FIGURE_37, one.jump, "V", f"peak amplitude less by {100 * one.reduction:.1f} %",
            )
            for one in wire.trials(printed)
            if one.slack != best.slack
        ),
    ]  # fmt: skip


def _follows(printed: Printed) -> list[Claim]:
    one, other = wire.controlled(printed).sweep, wire.without(printed)
    return [
        Claim.calibrated(
            "wire-current-drop", "drop of the motor's current at the jump", FIGURE_38,
            printed.current_drop, other.most_current - one.most_current, "A",
            "follows from both jump voltages and the calibrated resistance: a weak check",
        ),
        Claim.reported(
            "wire-initial-rise", "voltage up to which both amplitudes agree within 10 %", COMPARED,
            wire.agreement(printed), "V",
            "not fitted: \"the initial amplitudes are very similar\", for the wire is not hot yet",
        ),
    ]  # fmt: skip


def _control(printed: Printed) -> list[Claim]:
    found = wire.controlled(printed)
    result, why = found.result, "with 1.1 A, the published peak; film coefficient of closure B"
    return [
        Claim.reported(
            "wire-on", "motor voltage at which the wire is switched on", FIGURE_40,
            wire.RATE * found.on, "V", f"{printed.switching_frequency:g} Hz of the rotor",
        ),
        Claim.reported(
            "wire-off", "motor voltage at which it is switched off for good", FIGURE_40,
            wire.RATE * found.off, "V",
            f"amplitude below {100 * wire.SHARE:g} % of its peak: assumed, and after the jump",
        ),
        Claim.reported(
            "wire-temperature", "highest temperature of the wire", FIGURE_40,
            max(result["temperature"]) - machines.ZERO, "degC", why,
        ),
        Claim.reported(
            "wire-stress", "highest stress in the wire", FIGURE_40, 1e-6 * max(result["stress"]),
            "MPa", why,
        ),
    ]  # fmt: skip


def _actuator(printed: Printed) -> list[Claim]:
    volts = printed.heating_voltages[-1]
    return [
        Claim.calibrated(
            "actuator-current", f"current at {printed.complete_at:g} V, wire alone", BENCH,
            printed.current_there, actuator.at_end(printed.complete_at, "current"), "A",
            "closure B reads Table 1 as ohms per metre because of this current: 0.60 A cold, "
            "0.69 A once it has transformed",
        ),
        Claim.checked(
            "actuator-complete", "voltage from which the wire transforms completely", BENCH,
            printed.complete_at, actuator.complete_from(printed), "V", 0.05,
            "alloy assumed; the thesis says 0.9 V, above 1 V and 1.1 V in turn, and its Table 2 "
            "has 73 °C at 0.9 V",
        ),
        Claim.reported(
            "actuator-strain", f"strain recovered at {volts:g} V", BENCH,
            100.0 * actuator.recovered(volts), "%", "alloy assumed; the figures are not at hand",
        ),
    ]  # fmt: skip
