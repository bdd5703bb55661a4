"""The log that a page without a server has at hand: a run of the default wire with other numbers, and noise."""

from __future__ import annotations

import numpy as np

from martensite.app.documents import build_packaged, list_standalone

MODEL = "constant_power"
NUMBERS = {"element.law.A_s": "62 degC", "element.law.A_f": "80 degC", "element.law.M_s": "53 degC"}
"""What a fit should find: other numbers than the scenario has."""
POWER = ((0.0, 0.0), (0.5, 0.0), (2.0, 0.45), (4.0, 0.45), (5.0, 0.25), (6.5, 0.5), (8.0, 0.0), (12.0, 0.0))
"""Times [s] and power [W]: up, a turn on the way down, and up again."""
ROWS = 241
NOISE = 0.005
"""Standard deviation of what is measured, as a share of its range."""
SEED = 11


def make_sample() -> str:
    """A table over time of power, position and resistance, in the units of a logger."""
    waveform = {
        "kind": "table",
        "times": [f"{time} s" for time, _ in POWER],
        "values": [f"{power} W" for _, power in POWER],
    }
    run = {"run.duration": f"{POWER[-1][0]} s", "run.samples": ROWS, "drive.waveform": waveform}
    result = build_packaged(list_standalone()[MODEL], {**NUMBERS, **run}).run()
    draw = np.random.default_rng(SEED)
    measured = [np.asarray(result.columns[name]) for name in ("position", "resistance")]
    noisy = [column + NOISE * np.ptp(column) * draw.standard_normal(ROWS) for column in measured]
    rows = zip(result.times, result.columns["drive"], 1e3 * noisy[0], noisy[1], strict=True)
    lines = [f"{t:.6g},{p:.6g},{x:.6g},{r:.6g}" for t, p, x, r in rows]
    return "\n".join(["time [s],power [W],position (mm),R [ohm]", *lines, ""])
