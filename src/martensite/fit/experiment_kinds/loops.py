"""Loops in a testing machine, whose temperature is prescribed: what isobaric and isothermal experiments share."""

from __future__ import annotations

import tomllib

from martensite.fit.experiment_kinds.values import Document

ROWS = 160
"""Rows of a loop that are compared: a law without rates depends on turning points only."""
MACHINE = """
title = "{title}"
element = {{ kind = "wire", material = "flexinol-90", diameter = "{wide}", length = "{long}", initial_fraction = {xi} }}
mechanism = {{ kind = "testing-machine", control = "{control}", {size} }}
signals = {{ command = {{ kind = "log", column = "{control}" }} }}
drive = {{ kind = "temperature", waveform = {{ kind = "log" }} }}
run = {{ step = "1e3 s" }}
"""
ROUNDNESS = tuple(f"n_{k}=0.1..1" for k in (1, 2, 3, 4))
SLOPES = ("C_A=2..30 MPa/K", "C_M=2..30 MPa/K")


def read_machine(**entries: object) -> Document:
    """Return the scenario of a testing machine."""
    return tomllib.loads(MACHINE.format(**entries))


def with_law(base: Document, law: Document) -> Document:
    """Return a scenario with another law of its element."""
    return base | {"element": base["element"] | {"law": law}}
