"""The sections of a scenario that describe a thin wire against a spring, without what drives it."""

THIN_WIRE = """
[element]
kind = "wire"
material = "flexinol-90"
law = { kind = "liang-rogers", modulus = "mixture" }
diameter = "0.15 mm"
length = "250 mm"

[environment]
temperature = "22 degC"
cooling = { kind = "constant", h = "120 W/m^2/K" }

[mechanism]
kind = "bias-spring"
stiffness = "0.15 N/mm"
preload = "1.2 N"
"""
