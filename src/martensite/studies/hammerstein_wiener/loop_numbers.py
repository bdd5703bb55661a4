"""Claims on the closed loop: gains tuned on a model alone, applied to model and bench."""

from __future__ import annotations

import numpy as np

from martensite.studies.base import Claim
from martensite.studies.hammerstein_wiener import loops
from martensite.studies.hammerstein_wiener.bench import INTERVAL
from martensite.studies.hammerstein_wiener.fit_claims import BETTER, OURS, WHOLE
from martensite.studies.hammerstein_wiener.loop import LEVELS
from martensite.studies.hammerstein_wiener.printed import CONTROL, Printed

SMALL, LOOSE = "stage 2, 12 wavelets", "stage 2, not anchored"
BEGIN = LEVELS[0][1]
"""When the first step comes [s]."""
MICRONS = 10e-6
"""What "of the order of micrometres" is taken to allow [m]."""


def claims(printed: Printed, *, full: bool) -> list[Claim]:
    """Steps and sine; in full also other models, and the trap of a model without a rest."""
    more = [*_slower(), *_trap(), *_others()] if full else []
    return [*_steps(WHOLE, "whole"), *_sine(), *more]


def _steps(name: str, id: str) -> list[Claim]:
    both = loops.steps(name)
    pairs = both.responses()
    found = [
        Claim.reported(f"{id}-likeness", f"fit of the steps of the model to the bench, {name}",
                       OURS, both.likeness, "%", "one set of gains, tuned on the model alone")
    ]  # fmt: skip
    for k, (model, bench) in enumerate(pairs, start=1):
        found += [
            Claim.reported(f"{id}-rise-{k}", f"rise of the bench in step {k}, {name}", OURS,
                           bench.rise, "s", f"by the model {model.rise:.3f} s"),
            Claim.reported(f"{id}-overshoot-{k}", f"overshoot of the bench in step {k}, {name}",
                           OURS, 100.0 * bench.overshoot, "%",
                           f"by the model {100.0 * model.overshoot:.2f} %"),
            Claim.reported(f"{id}-settling-{k}", f"settling of the bench in step {k}, {name}",
                           OURS, bench.settling, "s", f"by the model {model.settling:.3f} s"),
        ]  # fmt: skip
    last = pairs[-1][1]
    return [
        *found,
        Claim.checked(f"{id}-steady", "steady error in position control", CONTROL, 0.0,
                      abs(last.error), "m", MICRONS,
                      '"tracks the reference with accuracy"; a tolerance of 10 µm is taken'),
    ]  # fmt: skip


def _sine() -> list[Claim]:
    found = loops.sines(WHOLE)
    heating, cooling = found.branches
    return [
        Claim.checked("sine-apart", "error between model and bench under a sine, rms", CONTROL,
                      0.0, found.apart, "m", MICRONS,
                      '"of the order of µm"; here it is a fraction of a millimetre, most of it '
                      "while the wire cools, where no controller can drive it"),
        Claim.reported("sine-tracking", "error of the bench under a sine, rms", OURS,
                       found.tracking, "m", "4 ± 1.5 mm at 0.04 Hz"),
        Claim.reported("sine-heating", "the same while the reference rises, rms", OURS,
                       heating, "m", "heated"),
        Claim.reported("sine-cooling", "the same while the reference falls, rms", OURS,
                       cooling, "m", "left to cool"),
    ]  # fmt: skip


def _slower() -> list[Claim]:
    both = loops.steps(SMALL)
    (model, _), *_ = both.responses()
    done = round((BEGIN + model.rise) / INTERVAL)
    share = both.bench.output[done] / model.after
    return [
        Claim.reported("first-step-slower", "how far the bench is when the model has risen to 90 %",
                       CONTROL, 100.0 * share, "%",
                       "the paper finds the real wire slower than its model in the first step, "
                       "from cold martensite; so is the bench beside the paper's structure"),
    ]  # fmt: skip


def _trap() -> list[Claim]:
    loose = loops.gains(LOOSE)
    still = float(loops.controlled(LOOSE).chain.simulate(np.zeros((1, 1)))[0, -1])
    why = (
        "fitted without anchoring to a record that never rests: the model is arbitrary where the "
        "controller has to begin"
    )
    return [
        Claim.reported("trap-rest", "position at rest by a model without a rest", OURS, still, "m",
                       why),
        Claim.reported("trap", "way of the bench under gains tuned on that model", OURS,
                       loops.moved(loose.gains), "m", f"the reference goes to 6 mm; {why}"),
    ]  # fmt: skip


def _others() -> list[Claim]:
    found: list[Claim] = []
    for name, id in ((SMALL, "paper"), (BETTER, "hysteresis")):
        both = loops.steps(name)
        found.append(
            Claim.reported(f"{id}-likeness", f"fit of the steps of the model to the bench, {name}",
                           OURS, both.likeness, "%", "as above")
        )  # fmt: skip
        found.append(
            Claim.reported(f"{id}-sine-apart", f"model and bench under a sine, rms, {name}", OURS,
                           loops.sines(name).apart, "m", "as above")
        )  # fmt: skip
    return found
