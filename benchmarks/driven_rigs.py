"""Rigs drawn at random: a driven element under a weight, against a spring or between grips, and its logs.

Every fifth rig is outside of what is fitted: another law, another heat loss, a drifting ambient, friction, a delay, or
a sensor that is nonlinear, slow or drifts.
A rig gives three logs of different cadence and one more, of a cadence that none of the three has.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.scenario.scenario import read_scenario
from martensite.search.lags import filter_lag
from martensite.signals.records import Record

DRIVES = ("voltage", "current", "power", "duty")
SHAPES = ("steps", "sine", "pulses", "pwm")
OUTSIDE = ("law", "loss", "ambient", "friction", "delay", "sensor", "lag", "drift")
UNIT = {"voltage": "V", "current": "A", "power": "W", "duty": "1"}
TEXT = """
[element]
kind = "wire"
material = "flexinol-90"
law = {{ {law}, C_A = "{slope} MPa/K", C_M = "{slope} MPa/K", A_s = "{A_s} degC", A_f = "{A_f} degC", \
M_s = "{M_s} degC", M_f = "{M_f} degC", E_A = "{E_A} GPa", E_M = "{E_M} GPa" }}
diameter = "{d} mm"
length = "{length} mm"
heat_capacity = "{c} J/kg/K"
latent_heat = "{latent} J/kg"

[environment]
temperature = "{ambient} degC"
cooling = {{ {cooling} }}

[mechanism]
{mechanism}
{signals}
[drive]
{drive}
waveform = {{ kind = "log" }}

[run]
tolerance = 2e-3
"""


@dataclass(frozen=True)
class Rig:
    """What a rig is, and its logs."""

    mechanism: str
    drive: str
    outside: str
    """What is outside of the models that are tried; empty for nothing."""
    records: tuple[Record, ...]
    unseen: Record
    """At a cadence that none of the records has."""
    column: str
    """What was measured."""


def draw_rig(seed: int, records: int = 3) -> Rig:
    """A rig and its logs; every fifth is outside of what is fitted."""
    chance = np.random.default_rng(seed)
    mechanism = str(chance.choice(["weight", "spring", "clamped"]))
    drive, outside = str(chance.choice(DRIVES)), str(chance.choice(OUTSIDE)) if seed % 5 == 4 else ""
    d = float(chance.choice([0.1, 0.15, 0.25, 0.38, 0.5]))
    wire = {
        "d": d,
        "length": chance.uniform(80, 400),
        "h": 60.0 * (0.25 / d) ** 0.6 * chance.uniform(0.7, 2.0),
        "c": chance.uniform(400, 850),
        "latent": chance.uniform(8e3, 25e3),
        "ambient": chance.uniform(18, 27),
        "slope": chance.uniform(6, 10),
        "E_A": chance.uniform(50, 80),
        "E_M": chance.uniform(20, 35),
    }
    top, wide, apart = chance.uniform(62, 92), chance.uniform(6, 22), chance.uniform(8, 22)
    wire |= {"A_f": top, "A_s": top - wide, "M_s": top - apart, "M_f": top - apart - chance.uniform(6, 22)}
    eps, sigma = chance.uniform(0.028, 0.05), chance.uniform(60, 180) * 1e6
    law = f'kind = "liang-rogers", modulus = "mixture", eps_L = {eps}'
    if outside == "law":
        law = (
            f'kind = "lagoudas", hardening = "waisted", H_min = {eps}, H_sat = {eps}, H_k = "0 1/MPa", '
            f'sigma_cal = "150 MPa", n_1 = 0.4, n_2 = 0.6, n_3 = 0.4, n_4 = 0.6, waist_f = 0.9, waist_r = 0.9'
        )
        wire |= {"A_s": top - 60.0, "M_f": top - apart - 60.0}
    cooling = f'kind = "constant", h = "{wire["h"]} W/m^2/K"'
    if outside == "loss":  # from 40 % at the ambient temperature to 130 % at the highest
        cooling = f'kind = "polynomial", h0 = "{0.2 * wire["h"]} W/m^2/K", h1 = "{0.012 * wire["h"]} W/m^2/K^2"'
    force = sigma * np.pi / 4.0 * (1e-3 * d) ** 2
    stroke = 1e-3 * wire["length"] * eps
    words = {
        "weight": f'kind = "dead-weight"\nmass = "{force / 9.80665} kg"',
        "spring": f'kind = "bias-spring"\npreload = "{0.6 * force} N"\n'
        f'stiffness = "{chance.uniform(0.2, 0.9) * force / stroke} N/m"',
        "clamped": f'kind = "testing-machine"\ncontrol = "elongation"\npreload = "{0.3 * force} N"',
    }
    signals = '\n[signals.command]\nkind = "constant"\nlevel = "0 mm"\n' if mechanism == "clamped" else ""
    ohms = 9e-7 * 1e-3 * wire["length"] / (np.pi / 4.0 * (1e-3 * d) ** 2)
    hot = top + sigma / (1e6 * wire["slope"]) + chance.uniform(15, 50)
    power = wire["h"] * np.pi * 1e-6 * d * wire["length"] * (hot - wire["ambient"])
    level = {"voltage": np.sqrt(power * ohms), "current": np.sqrt(power / ohms), "power": power, "duty": 0.6}[drive]
    kind = f'kind = "{drive}"'
    if drive == "duty":
        kind = f'kind = "pwm-voltage"\nsupply = "{np.sqrt(power * ohms / 0.6)} V"'
    text = TEXT.format(**wire, cooling=cooling, law=law, mechanism=words[mechanism], signals=signals, drive=kind)
    tau = 6450.0 * wire["c"] * 1e-3 * d / (4.0 * wire["h"])
    output = "force" if mechanism == "clamped" else "position"
    shape, noise = str(chance.choice(SHAPES)), chance.uniform(0.003, 0.02)
    periods = tau * np.array([5.0, 9.0, 24.0, 14.0]) * chance.uniform(0.7, 1.3, 4)
    logs: list[Record] = []
    for k in (*range(records), 3):
        rows = int(chance.integers(250, 600))
        times = np.linspace(0.0, chance.uniform(3, 5) * periods[k], rows)
        u = level * draw_drive(shape, times / periods[k], chance)
        moved = simulate_log(text, times, u, drive, output, outside, tau, chance)
        moved = moved + noise * np.ptp(moved) * chance.standard_normal(rows)
        columns = {"time": times.tolist(), drive: u.tolist(), output: moved.tolist()}
        units = {"time": "s", drive: UNIT[drive], output: "N" if output == "force" else "m"}
        logs.append(Record(f"log{k + 1}", columns, units))
    return Rig(mechanism, drive, outside, tuple(logs[:-1]), logs[-1], output)


def draw_drive(shape: str, cycles: Any, chance: np.random.Generator) -> Any:
    """A drive from 0 to 1 over so many cycles."""
    phase, number = cycles % 1.0, cycles.astype(int)
    heights = chance.uniform(0.7, 1.0, number.max() + 2)
    if shape == "sine":
        return heights[number] * 0.5 * (1.0 - np.cos(2.0 * np.pi * phase))
    if shape == "pulses":
        return heights[number] * 1.15 * (phase < chance.uniform(0.25, 0.4))
    if shape == "pwm":  # slow: ten switchings per cycle, fewer and shorter in its second half
        share = np.where(phase < 0.5, 0.8, 0.15) * heights[number]
        return 1.1 * ((10.0 * cycles) % 1.0 < share)
    steps = np.floor(4.0 * phase)
    return heights[number] * np.choose(steps.astype(int), [0.55, 1.0, 0.6, 0.0])


def simulate_log(
    text: str, times: Any, u: Any, drive: str, output: str, outside: str, tau: float, chance: np.random.Generator
) -> Any:
    """What is measured at the times of the rows, without noise."""
    heat = 2.0 if drive in ("voltage", "current") else 1.0
    if outside == "ambient":  # as much more heat as a warmer room would leave in the wire
        drift = chance.uniform(0.15, 0.3) * np.max(np.abs(u)) ** heat * np.sin(np.pi * times / times[-1]) ** 2
        u = (np.abs(u) ** heat + drift) ** (1.0 / heat)
    record = Record("rig", {"time": times.tolist(), drive: u.tolist()}, {"time": "s", drive: UNIT[drive]})
    scenario = replace(read_scenario(text, log=record), samples=len(times))
    found = np.asarray(scenario.run()[output], float)
    if outside == "delay":
        found = np.interp(times - chance.uniform(0.8, 2.0) * tau, times, found)
    if outside == "lag":
        found = filter_lag(times, found[:, None], chance.uniform(0.7, 2.0) * tau, early=True)[:, 0]
    if outside == "drift":
        found = found + chance.uniform(0.1, 0.3) * np.ptp(found) * times / times[-1]
    if outside == "friction":  # the slider follows when the wire has moved by the slack
        slack, stuck = chance.uniform(0.04, 0.1) * np.ptp(found), [found[0]]
        for level in found[1:]:
            stuck.append(min(max(stuck[-1], level - slack), level + slack))
        found = np.array(stuck)
    if outside == "sensor":
        share = (found - found.min()) / max(np.ptp(found), 1e-30)
        found = found.min() + np.ptp(found) * share ** chance.uniform(1.6, 2.4)
    return found
