"""What headings of logs are taken for; a guess is checked against what reads logs unseen."""

import pytest

from martensite.fit.condition_headings import find_measure_words
from martensite.logs.heading_guess import SPELLINGS, guess_heading, usual_units
from martensite.logs.layout import CANONICAL, read_headings

HEADINGS = {
    "T [degC]": ("temperature", "degC"),
    "temp (C)": ("temperature", "degC"),
    "temp_ambient_C": ("temperature", "degC"),
    "Time_s": ("time", "s"),
    "time(ms)": ("time", "ms"),
    "t": ("time", ""),
    "F/N": ("force", "N"),
    "load cell kN": ("force", "kN"),
    "U in V": ("voltage", "V"),
    "strain %": ("strain", "%"),
    "Strain [-]": ("strain", "1"),
    "R [Ohm]": ("resistance", "ohm"),
    "I (mA)": ("current", "mA"),
    "Stress (N/mm²)": ("stress", "MPa"),
    "displacement_mm": ("position", "mm"),
    "Channel 3 (V)": ("voltage", "V"),
    "protagonist.temperature [degC]": ("protagonist.temperature", "degC"),
    "=cmd()": ("", ""),
    "time of day": ("time", ""),
    "Channel A": ("", ""),
    "Temp 1": ("temperature", ""),
    "Weight (g)": ("force", "gf"),
    "Strain (µε)": ("strain", "ppm"),
    "": ("", ""),
}


@pytest.mark.parametrize("heading", HEADINGS)
def test_headings_are_guessed(heading: str) -> None:
    found = guess_heading(heading)
    assert (found.name, found.unit) == HEADINGS[heading]


@pytest.mark.parametrize("heading", [h for h, (name, unit) in HEADINGS.items() if name and unit])
def test_a_guess_is_read_by_the_reader_of_logs(heading: str) -> None:
    found = guess_heading(heading)
    (column,) = read_headings([f"{found.name} [{found.unit}]"], "the log")
    assert column.name == found.name


def test_a_name_gives_way_to_a_unit_that_contradicts_it() -> None:
    assert guess_heading("temperature [V]").name == "temperature"  # as it is called: the reader refuses it
    assert guess_heading("temp drive [V]").name == "voltage"


@pytest.mark.parametrize("name", CANONICAL)
def test_usual_units_are_those_that_fit(name: str) -> None:
    found = usual_units(name)
    assert found
    for unit in found:
        assert read_headings([f"{name} [{unit}]"], "the log")[0].name == name
    assert set(found) < {*SPELLINGS, "clock", *found[:1]}


def test_words_of_quantities_are_those_of_all_readers() -> None:
    """What a heading of a log may be called, a measure in a table of conditions may be called, too."""
    assert (guess_heading("Contraction (mm)").name, guess_heading("voltage drop [V]").name) == ("position", "voltage")
    assert find_measure_words("peak contraction", ()) == find_measure_words("peak disp", ()) == "stroke"
    assert find_measure_words("mean thermocouple", ("temperature",)) == "mean(temperature)"
