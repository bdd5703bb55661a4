"""The figure of the study."""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.studies.figures import draw_page
from martensite.studies.sommerfeld import beam_panels, ramp_panels, wire_panels
from martensite.studies.tables import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_figure(printed: Printed) -> Figure:
    """Draw the figure."""
    with draw_page(
        15.0,
        9.2,
        "Motor with an unbalance on a beam: the Sommerfeld effect, and its change by a hot wire",
        "Simulated for this project. First row: Table 3 of the thesis. Second row: resistance, "
        "damping and mass calibrated to the measured ramp, slack of the wire fitted to both "
        "values of the thesis with the wire;",
        "alloy, length of the wire and rate of the ramp are assumed. Dotted lines: printed values.",
    ) as figure:
        grid = figure.add_gridspec(3, 4, left=0.038, right=0.962, top=0.885, bottom=0.055, wspace=0.34, hspace=0.38)
        beam_panels.draw_amplitude(figure.add_subplot(grid[0, 0]), printed)
        beam_panels.draw_speed(figure.add_subplot(grid[0, 1]), printed)
        beam_panels.draw_folds(figure.add_subplot(grid[0, 2]), printed)
        ramp_panels.draw_fit(figure.add_subplot(grid[0, 3]), printed)
        ramp_panels.draw_displacement(figure.add_subplot(grid[1, :2]), printed)
        ramp_panels.draw_speed(figure.add_subplot(grid[1, 2]), printed)
        ramp_panels.draw_current(figure.add_subplot(grid[1, 3]), printed)
        wire_panels.draw_control(figure.add_subplot(grid[2, 0]), printed)
        wire_panels.draw_loops(figure.add_subplot(grid[2, 1]), printed)
        wire_panels.draw_bench(figure.add_subplot(grid[2, 2]), printed, "strain")
        wire_panels.draw_bench(figure.add_subplot(grid[2, 3]), printed, "current")
        return figure
