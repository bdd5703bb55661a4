"""Texts of scenarios with one wire, with usual values for what a test does not give."""

MIXTURE = '{ kind = "liang-rogers", modulus = "mixture" }'
"""The law by default."""
SPRING = 'kind = "bias-spring"\nstiffness = "0.2 N/mm"\npreload = "4 N"'
STEP = 'kind = "current"\nwaveform = { kind = "step", high = "0.2 A", at = "1 s", until = "8 s" }'


def hang(mass: str) -> str:
    """Return the mechanism of a wire under a weight, such as "400 g"."""
    return f'kind = "dead-weight"\nmass = "{mass}"'


def cool(h: float) -> str:
    """Return a constant heat loss [W/m²/K]."""
    return f'{{ kind = "constant", h = "{h} W/m^2/K" }}'


def write_wire(
    title: str = "",
    *,
    law: str = MIXTURE,
    diameter: str = "0.25 mm",
    length: str = "200 mm",
    element: str = 'material = "flexinol-90"',
    ambient: str = "22 degC",
    cooling: str = cool(70),
    mechanism: str = SPRING,
    drive: str = STEP,
    run: str = 'duration = "30 s"',
) -> str:
    """Return the text of a scenario.

    Args:
        title: its title.
        law: the law of the wire, in TOML.
        diameter: diameter of the wire.
        length: length of the wire.
        element: further lines of the wire.
        ambient: ambient temperature.
        cooling: heat loss, in TOML; without it the section `environment` is left out.
        mechanism: lines of this section.
        drive: lines of this section; without it the section is left out.
        run: lines of this section; without it the section is left out.

    Returns:
        Text in TOML.
    """
    sections = {
        "element": f'kind = "wire"\n{element}\nlaw = {law}\ndiameter = "{diameter}"\nlength = "{length}"',
        "environment": cooling and f'temperature = "{ambient}"\ncooling = {cooling}',
        "mechanism": mechanism,
        "drive": drive,
        "run": run,
    }
    written = [f"[{name}]\n{lines}\n" for name, lines in sections.items() if lines]
    return "\n".join([f'title = "{title}"\n', *written] if title else written)


LIFTED = {
    "diameter": "0.381 mm",
    "length": "273 mm",
    "cooling": cool(60),
    "mechanism": hang("400 g"),
    "drive": 'kind = "voltage"\nwaveform = { kind = "step", high = "2.5 V", until = "20 s" }',
    "run": 'duration = "40 s"',
}
"""A wire that lifts 400 g."""
THIN = {
    "diameter": "0.15 mm",
    "length": "250 mm",
    "cooling": cool(120),
    "mechanism": 'kind = "bias-spring"\nstiffness = "0.15 N/mm"\npreload = "1.2 N"',
    "drive": "",
    "run": "",
}
"""A thin wire against a spring, without drive and run."""
THIN_WIRE = "\n" + write_wire(**THIN)
