"""Running a sweep for the command line, with signs of what is going on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.cli.sweep_show import Swept
from martensite.cli.waiting import spinner, sweep_bar

if TYPE_CHECKING:
    from pathlib import Path

    from martensite.design.sweep.api import How
    from martensite.design.sweep.job import Wanted
    from martensite.scenario.scenario import Scenario


def swept(scenario: Scenario, wanted: Wanted, path: Path, how: How) -> Swept:
    """Run what is missing of a sweep.

    Raises:
        InputError: an axis, an option or the store is wrong.
        StoppedError: it stopped on the way; what was made is kept.
    """
    from martensite.design.sweep.api import begin

    with spinner(f"preparing {scenario.title}"):
        begun = begin(scenario, wanted, path, how)
    with sweep_bar(scenario.title) as tell:
        progress = begun.run(tell)
    return Swept(begun.plan, begun.store, progress, begun.part)
