"""The blocks of a model one by one: curves of static ones, responses of linear ones.

A static block is drawn over the range of its input in a record, extended a little beyond. A linear block has a step
response and a frequency response.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import InputError
from martensite.identify.blocks.base import AbstractStatic
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.linear_system import LinearSystem
from martensite.identify.chains.linearise import linearise_chain
from martensite.show.figures.fit import SEEN
from martensite.show.figures.panels import add_panels, write_headline, write_title
from martensite.show.figures.style import FAINT, INK, SIMULATED, make_figure, use_style
from martensite.signals.sampling.sampled import Sampled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXTENSION = 0.15
"""Extension of a curve beyond the data, as a fraction of their range."""
POINTS = 401
CONSTANTS = 6.0
"""Duration of a step response in longest time constants."""
MOST_SAMPLES = 4000
"""Largest number of samples of a step response."""
DECADES = 3.5
"""Decades of a frequency response, below half the sample rate or around the slowest pole."""


def plot_static_blocks(chain: Chain, record: Sampled, title: str = "") -> Figure:
    """Draw each static block over its input in a record."""
    places = [k for k, block in enumerate(chain.blocks) if isinstance(block, AbstractStatic)]
    if not places:
        raise InputError(f"Model `{chain.text()}` has no static block.")
    with use_style():
        figure = make_figure(max(3.3 * len(places), 4.6), 3.5)
        write_headline(figure, title or f"Static blocks of {chain.name}")
        how = {"sharex": "col", "height_ratios": (4.0, 1.0)}
        panels = add_panels(figure, 2, len(places), (0.7, 0.15, 0.65, 0.49), (0.7, 0.1), **how)
        for place, (curve, counts) in zip(places, panels.T, strict=True):
            _draw_static(curve, counts, chain, place, record)
        return figure


def plot_linear_blocks(chain: Chain, title: str = "") -> Figure:
    """Draw step and frequency responses of each linear block."""
    places = [k for k, block in enumerate(chain.blocks) if block.linear]
    if not places:
        raise InputError(f"Model `{chain.text()}` has no linear block.")
    systems = [(f"{k + 1}: {chain.blocks[k].text()}", _isolate_block(chain, k)) for k in places]
    return plot_linear(systems, title or f"Linear blocks of {chain.name}")


def plot_linear(systems: list[tuple[str, LinearSystem]], title: str = "") -> Figure:
    """Draw step response, gain and phase of the first input and output of linear systems, one row each."""
    with use_style():
        figure = make_figure(9.6, 0.85 + 2.1 * len(systems))
        write_headline(figure, title)
        panels = add_panels(figure, len(systems), 3, (0.62, 0.14, 0.62, 0.48), (0.62, 0.7))
        for (name, linear), (step, gain, phase) in zip(systems, panels, strict=True):
            _draw_step(step, name, linear)
            _draw_bode(gain, phase, linear)
        for axes in panels[:-1].flat:
            axes.set_xlabel("")
        return figure


def _isolate_block(chain: Chain, place: int) -> LinearSystem:
    block = chain.blocks[place]
    own = Chain(
        (block,),
        chain.split()[place],
        chain.interval,
        tuple(f"x{i}" for i in range(block.inputs)),
        tuple(f"y{i}" for i in range(block.outputs)),
    )
    return linearise_chain(own, np.zeros(block.inputs))


def _draw_static(curve: Any, counts: Any, chain: Chain, place: int, record: Sampled) -> None:
    block = chain.blocks[place]
    x = chain.before(place, record)[:, 0]
    low, high = float(np.min(x)), float(np.max(x))
    room = EXTENSION * (high - low or 1.0)
    levels = np.linspace(low - room, high + room, POINTS)
    own = Chain((block,), chain.split()[place], chain.interval)
    y = own.simulate(levels)[:, 0]
    inside = (levels >= low) & (levels <= high)
    curve.axvspan(low, high, color=FAINT, alpha=0.5, linewidth=0.0, zorder=0.5)
    curve.plot(levels, y, color=SEEN, linewidth=1.0, linestyle=(0, (4, 3)))
    curve.plot(levels[inside], y[inside], color=SIMULATED, linewidth=1.6)
    curve.set_ylabel("output")
    write_title(curve, f"{place + 1}: {block.text()}", fontweight="bold", color=INK)
    counts.hist(x, bins=60, color=SEEN)
    counts.set_yticks([])
    counts.set_xlabel("input (seen: shaded)")


def _draw_step(axes: Any, name: str, linear: LinearSystem) -> None:
    constants = linear.time_constants()
    longest = float(np.max(constants[np.isfinite(constants)], initial=linear.interval))
    duration = min(CONSTANTS * longest, MOST_SAMPLES * linear.interval)
    times, y = linear.step_response(max(duration, 20.0 * linear.interval))
    axes.step(times, y[:, 0], where="post", color=SIMULATED)
    axes.set(xlabel="$t$ [s]", ylabel="step response")
    write_title(axes, name, fontweight="bold", color=INK)


def _draw_bode(gain: Any, phase: Any, linear: LinearSystem) -> None:
    half = 0.5 / linear.interval
    constants = linear.time_constants()
    slow = float(np.max(constants[np.isfinite(constants)], initial=linear.interval))
    low = min(0.02 / slow, half / 10.0**DECADES)
    f = np.geomspace(low, 0.999 * half, 400)
    response = linear.frequency_response(f)[:, 0, 0]
    gain.semilogx(f, 20.0 * np.log10(np.maximum(np.abs(response), 1e-300)), color=SIMULATED)
    phase.semilogx(f, np.degrees(np.unwrap(np.angle(response))), color=SIMULATED)
    for axes, words in ((gain, "gain [dB]"), (phase, "phase [°]")):
        axes.set(xlabel="$f$ [Hz]", ylabel=words, xlim=(low, half))
