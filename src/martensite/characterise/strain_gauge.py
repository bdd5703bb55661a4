"""A half bridge of strain gauges on a cantilever, and the amplifier behind it.

With a gauge on each face of the beam, at a distance L_e from a force F across its tip, one is
stretched by η as the other is shortened by it:

    η = 6 F L_e/(E b h²),    V_out/V_b = k η/2,    G = 1 + 49.4 kΩ/R_G

for a section of width b and height h, gauge factor k, bridge supply V_b and the INA129.
Source: Kossoski (2018), Appendix A; Texas Instruments, INA129 data sheet, section 9.2.2.1.
"""

from __future__ import annotations

from martensite.base.errors import ParameterError

INA129 = 49.4e3
"""Sum of the two feedback resistors in the INA129 [ohm]."""


def bending_strain(force: float, arm: float, E: float, width: float, height: float) -> float:
    """Strain η of the outer fibre [-] of a beam with modulus E [Pa], `arm` [m] from a force [N].

    Raises:
        ParameterError: modulus, width or height is not above 0.
    """
    if min(E, width, height) <= 0.0:
        raise ParameterError(
            f"Modulus, width and height must be above 0, but are {E:g} Pa, {width:g} m and {height:g} m."
        )
    return 6.0 * force * arm / (E * width * height**2)


def half_bridge(strain: float, gauge_factor: float) -> float:
    """V_out/V_b [-] of two active gauges, of which one has the strain η and the other -η."""
    return 0.5 * gauge_factor * strain


def ina129_gain(resistance: float) -> float:
    """Gain [-] of an INA129 with the resistor R_G [ohm].

    Raises:
        ParameterError: the resistance is not above 0.
    """
    if not resistance > 0.0:
        raise ParameterError(f"Argument `resistance` must be above 0 ohm, but is {resistance:g}.")
    return 1.0 + INA129 / resistance
