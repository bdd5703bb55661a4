"""Numbers of the wire: a fit of its slack on the beam, its control, and its own test bench.

The thesis gives neither length, slack, attachment nor alloy of the wire, nor the rate of the ramp. No number here is a
prediction.
"""

from __future__ import annotations

from typing import Any

from martensite.studies.readings import ZERO
from martensite.studies.sommerfeld import actuator, wire
from martensite.studies.tables import Printed


def compute_wire(printed: Printed) -> dict[str, Any]:
    """Return the fit, its consequences, the control signal, and the actuator alone."""
    best, controlled = wire.best_trial(printed), wire.run_controlled(printed)
    result, volts = controlled.result, printed.heating_voltages[-1]
    return {
        "best": best,
        "best_slack": 100 * best.slack,
        "by_jump": 100 * wire.slack_for(printed, "jump", printed.jump_with_wire),
        "by_size": 100 * wire.slack_for(printed, "reduction", printed.reduction),
        "tried": ", ".join(f"{100 * slack:g}" for slack in wire.SLACKS),
        "trials": [
            {"slack": 100 * one.slack, "jump": one.jump, "reduction": 100 * one.reduction}
            for one in wire.run_trials(printed)
            if one.slack != best.slack
        ],
        "wire_current_drop": wire.run_without_wire(printed).most_current - controlled.sweep.most_current,
        "wire_initial_rise": wire.agreement_voltage(printed),
        "wire_on": wire.RATE * controlled.on,
        "wire_off": wire.RATE * controlled.off,
        "share": 100 * wire.SHARE,
        "wire_temperature": result.measure("max(temperature)") - ZERO,
        "wire_stress": 1e-6 * result.measure("max(stress)"),
        "actuator_current": actuator.at_end(printed.complete_at, "current"),
        "actuator_complete": actuator.complete_from(printed),
        "volts": volts,
        "actuator_strain": 100.0 * actuator.recovered_strain(volts),
    }
