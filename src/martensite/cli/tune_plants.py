"""Plants of a tuning for the command line: spreads as text, and the judgement on other plants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from martensite.base.errors import InputError, ParameterError, suggest_name
from martensite.cli.options import read_quantity

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.design.tuning.bench_tuning import TunedBench
    from martensite.design.tuning.loop_runs import LoopRuns
    from martensite.design.tuning.plant_comparison import Ratio
    from martensite.design.tuning.plant_spread import Plants
    from martensite.scenario.scenario import Scenario

PLANTS = 64


def draw_both_plants(
    texts: Sequence[str], count: int | None, seed: int, scenario: Scenario, bench: Bench
) -> tuple[Plants | None, Plants | None]:
    """Plants to tune on, and others to judge on; none without a spread.

    Raises:
        InputError: a text is no spread of a number of the plant.
    """
    if not texts:
        return None, None
    from martensite.design.tuning.plant_spread import draw_plants

    spreads = dict(_read_spread(text, scenario, bench) for text in texts)
    first, second = (draw_plants(bench, spreads, PLANTS if count is None else count, seed + k) for k in (0, 1))
    return first, second


def _read_spread(text: str, scenario: Scenario, bench: Bench) -> tuple[str, float]:
    """Path in the plant and spread of an option."""
    name, equals, size = (part.strip() for part in text.partition("="))
    if not equals:
        raise InputError(f'`{text}` is no spread; write `PATH=SPREAD`, e.g. element.diameter="3 %".')
    places = scenario.places
    written = {leaf.path: places.path(f"plant.{leaf.path}") for leaf in bench.plant.leaves()}
    paths = [p for p, w in written.items() if name in (p, w)] or [
        p for p, w in written.items() if w.endswith(f".{name}") or p.endswith(f".{name}")
    ]
    if len(paths) != 1:
        some = ", ".join(f"`{written[p]}`" for p in paths)
        fault = f"is ambiguous: {some}." if paths else "is no number of the plant."
        hint = "" if paths else f" {suggest_name(name, written.values())}"
        raise ParameterError(f"`{name}` {fault}{hint}")
    unit = next(x.declared.unit for x in bench.plant.leaves() if x.path == paths[0])
    if unit == "K" and "deg" in size:
        raise InputError(f"A spread of a temperature is a difference: write `{name}=3 K`.")
    return paths[0], read_quantity("spread", size, "K" if unit == "K" else "1")


def judge_others(runs: LoopRuns, found: TunedBench, others: Plants | None) -> Ratio | None:
    """ITAE after over before on plants that were not tuned on."""
    if others is None:
        return None
    from martensite.design.tuning.plant_comparison import compare_over_plants

    both = compare_over_plants(runs, {"before": found.before, "after": found.after}, others)
    return both.ratio("after", "before")
