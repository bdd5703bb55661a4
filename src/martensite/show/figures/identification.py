"""Measured and computed outputs of an identified model, record by record, in free run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from martensite.base.formats import typeset_unit
from martensite.show.figures.panels import add_legend_above, make_panels
from martensite.show.figures.style import MEASURED, SIMULATED, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from martensite.identify.chains.stages import Identified
    from martensite.signals.sampling.sampled import Sampled

MOST_PANELS = 6
"""Records drawn at most."""
MOST_POINTS = 4000
"""Samples of a record drawn at most."""


def plot_identified(found: Identified, records: Sequence[Sampled], title: str = "") -> Figure:
    """Draw the (last) output of a model, or of the series of its stages, beside the measured.

    Args:
        found: what `identify_stages` found.
        records: the records to draw, which have its inputs and its output.
        title: headline.
    """
    shown = list(records)[:MOST_PANELS]
    with use_style():
        headline = title or f"{found.model.text()}, free run"
        figure, grid = make_panels(7.5, 1.0 + 2.0 * len(shown), len(shown), 1, headline)
        panels = grid[:, 0]
        for panel, record in zip(panels, shown, strict=True):
            _draw_panel(panel, found, record)
        panels[-1].set_xlabel("time [s]")
        add_legend_above(panels[0])
        return figure


def _draw_panel(panel: Any, found: Identified, record: Sampled) -> None:
    from martensite.identify.chains.goals import AUTO
    from martensite.identify.chains.scores import fit_percent, free_run
    from martensite.signals.sampling.resampling import select_signals

    names = found.stages[-1].outputs
    own = select_signals(record, found.model.input_names, names)
    skip = found.options.skip
    start = AUTO if found.options.start == "estimate" else found.options.start
    computed = free_run(found.model, own, start, skip)
    fit = float(fit_percent(own.outputs, computed, skip)[-1])
    kept = slice(None, None, max(len(own) // MOST_POINTS, 1))
    times, unit = own.times[kept], own.units.get(names[-1], "1")
    panel.plot(times, own.outputs[kept, -1], color=MEASURED[0], label="measured")
    panel.plot(times, computed[kept, -1], color=SIMULATED, linewidth=1.0, label="free run")
    panel.set_title(f"{record.name}: fit {fit:.1f} %")
    panel.set_ylabel(f"{names[-1]} [{typeset_unit(unit, '–')}]")
