"""Circuit that measures the resistance of a wire, from parts that are sold, and the noise of its readings.

A shunt stands between the switch and ground. A current-sense amplifier with Kelvin leads at the shunt gives the
current; a difference amplifier of an operational amplifier and four resistors, with Kelvin leads at both ends of the
wire, gives the voltage. Both outputs are converted while the switch is closed, after they have settled:

    σ_R/R = √((σ_U/U)² + (σ_I/I)²),    t_settle = (n + 1) ln 2 (τ_amplifier + τ_filter)

for a converter of n bits, which then is within half a step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.base.errors import InputError
from martensite.boards.firmware.boards import Board

SHUNTS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""Shunts that are sold [ohm]."""
AMPLIFIER, BANDWIDTH, AMPLIFIER_NOISE = 50.0, 210e3, 40e-9
"""Gain, bandwidth [Hz] and input noise [V/√Hz] of the current-sense amplifier; data sheet of INA180A2, SBOS741."""
FILTER = (1e3, 1e-9)
"""Resistor [ohm] and capacitor [F] before a converter that reads pulses."""
AMPLIFIER_LAG = 1.0 / (2.0 * math.pi * BANDWIDTH) + FILTER[0] * FILTER[1]
"""Time constant of amplifier and filter [s]."""
CONVERTER_NOISE = 1.0
"""Standard deviation of a conversion, with its resolution [steps]; assumed."""
POLL = 5e-6
"""Time in which the firmware notices that the amplifiers have settled [s]."""
DIVIDERS = {1.0: "", 2.0: "10 kilohm", 3.0: "20 kilohm", 5.0: "40 kilohm", 11.0: "100 kilohm"}
"""Upper resistor of a divider with 10 kilohm to ground, by ratio."""
DIFFERENCES = {1.0: "100 kilohm", 2.0: "49.9 kilohm", 3.0: "33.2 kilohm", 5.0: "20 kilohm", 11.0: "9.09 kilohm"}
"""Feedback resistor of a difference amplifier with inputs of 100 kilohm, by ratio."""
OVER = 1.1
"""Range of the difference amplifier over the supply."""
FUSES = (
    *(0.1, 0.125, 0.16, 0.2, 0.25, 0.315, 0.4, 0.5, 0.63, 0.8),
    *(1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0, 10.0, 12.5, 16.0, 20.0),
)
"""Rated currents of IEC 60127 [A]."""
HIGHEST_SUPPLY = 60.0
"""Extra-low voltage for direct current [V]; IEC 61140."""
MARGIN = 1.25
"""Current over the largest expected current at which the board disarms; least rating of fuse and supply."""


@dataclass(frozen=True)
class Circuit:
    """Parts and properties of the measurement of resistance on a board."""

    shunt: float
    """[ohm]"""
    ratio: float
    """Voltage across the wire over the output of the difference amplifier."""
    settle: float
    """Time from a closed switch to settled amplifiers [s]."""
    pulse: float
    """Shortest pulse in which resistance is measured [s]."""
    noise: float
    """Standard deviation of a reading of the resistance over the reading."""


def plan_circuit(board: Board, supply: float, currents: tuple[float, float]) -> Circuit:
    """Return the circuit of a board.

    Args:
        board: board.
        supply: supply voltage [V].
        currents: lowest and highest current of a closed switch [A].

    Raises:
        InputError: no part fits.
    """
    least, most = currents
    fitting = [one for one in SHUNTS if one * AMPLIFIER * MARGIN * most <= board.volts]
    if not fitting:
        limit = board.volts / (SHUNTS[0] * AMPLIFIER * MARGIN)
        raise InputError(f"The wiring measures at most {limit:.3g} A, but a closed switch carries {most:.3g} A.")
    shunt, ratio = fitting[-1], choose_divider(OVER * supply, board)
    settle = (math.log2(board.steps) + 1.0) * math.log(2.0) * AMPLIFIER_LAG
    step = board.volts / board.steps
    amplified = AMPLIFIER * AMPLIFIER_NOISE * math.sqrt(0.5 * math.pi * BANDWIDTH) / step
    current = math.hypot(CONVERTER_NOISE, amplified) * step / (least * shunt * AMPLIFIER)
    voltage = CONVERTER_NOISE * step * ratio / supply
    return Circuit(shunt, ratio, settle, settle + board.hold + POLL, math.hypot(current, voltage))


def choose_divider(volts: float, board: Board) -> float:
    """Return the least ratio with which a board measures a voltage [V].

    Raises:
        InputError: the voltage is too high.
    """
    for ratio in DIVIDERS:
        if volts <= ratio * board.volts:
            return ratio
    raise InputError(f"The wiring measures at most {max(DIVIDERS) * board.volts:g} V, but there are {volts:g} V.")


def choose_fuse(current: float) -> float:
    """Return the least rated current [A] of a fuse that carries a current [A].

    Raises:
        InputError: the current is too large.
    """
    for one in FUSES:
        if current <= one:
            return one
    raise InputError(f"The wiring has fuses up to {FUSES[-1]:g} A, but this loop needs {current:.3g} A.")
