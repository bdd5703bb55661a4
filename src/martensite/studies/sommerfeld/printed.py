"""Every number of the thesis's chapters 3 to 5 that this study uses, in SI units except °C."""

from __future__ import annotations

from dataclasses import dataclass

THESIS = "kossoski2018"
"""Key of the thesis in the bibliography."""


@dataclass(frozen=True)
class Printed:
    """The thesis's numbers."""

    # Table 3: beam and motor
    stiffness: float = 541.0
    """[N/m]"""
    damping: float = 0.07
    """[N s/m]"""
    mass: float = 0.25
    """[kg]"""
    unbalance: float = 0.012
    """[kg]"""
    eccentricity: float = 0.02
    """[m]"""
    constant: float = 0.0211
    """K_T [N m/A] and K_B [V s/rad]"""
    rotor_inertia: float = 0.82e-4
    """[kg m²]"""
    inductance: float = 3.1e-3
    """[H]"""
    friction: float = 8.17e-7
    """[N m s/rad]"""
    resistance: float = 41.0
    """[ohm]"""
    # Table 4: beam
    density: float = 2700.0
    """[kg/m³]"""
    young: float = 69e9
    """[Pa]"""
    length: float = 0.32
    """[m]"""
    width: float = 0.038
    """[m]"""
    height: float = 0.003
    """[m]"""
    # Table 5 and section 5.1.2
    computed_stiffness: float = 540.115
    """[N/m]; printed in Pa"""
    second_mass: float = 0.19
    """[kg]: another value of the mass in Table 3"""
    analytical_frequency: float = 8.42
    """[Hz]"""
    measured_frequency: float = 8.36
    """[Hz]"""
    # Sections 4.3.2 and 5.1.3: voltage of the jump
    simulated_jump: float = 6.6
    """[V]"""
    # Section 5.2.2: ramps without and with the wire
    jump: float = 6.38
    """[V]"""
    amplitude: float = 0.054
    """[m]; with it 42.59 % less is 31 mm. The text says "approximately 0.052 meters"."""
    amplitude_in_text: float = 0.052
    """[m]"""
    jump_with_wire: float = 5.2
    """[V]"""
    earlier: float = 2.0
    """[V], "almost", by which the jump with the wire is earlier"""
    reduction: float = 0.4259
    """of the amplitude"""
    current_drop: float = 0.2
    """Of the motor's current at the jump [A]"""
    wire_current: float = 1.1
    """Peak current in the wire [A]"""
    # Section 5.2.1
    wire_angle: float = 15.0
    """[deg]"""
    switching_frequency: float = 3.0
    """Of the rotor, at which the wire is switched on [Hz]"""
    last_voltage: float = 14.0
    """End of the ramp [V]"""
    # Section 3.2.2
    heating_voltages: tuple[float, ...] = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
    """[V]"""
    complete_at: float = 0.9
    """Voltage at which the wire is said to transform completely [V]"""
    current_there: float = 0.69
    """[A]"""
