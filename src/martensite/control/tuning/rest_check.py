"""Check that the steady states of a model for tuning lie within its records."""

from __future__ import annotations

from collections.abc import Sequence

from martensite.base.errors import ParameterError
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.linearise import operating_point, static_curve

REST_MARGIN = 0.25
"""Fraction of a range by which a steady state may exceed it."""
CURVE = 21
"""Number of checked points of a static curve."""


def check_static_curve(chain: Chain, idle: float, targets: Sequence[float] = (), number: int = -1) -> None:
    """Raise `ParameterError` if a model has steady states outside its records.

    Targets of the output are relative to the steady output at the idle input. A model of several inputs, or without the
    ranges of its records, is not checked.
    """
    name, output = chain.input_names[0], chain.output_names[number]
    if chain.inputs != 1 or name not in chain.ranges or output not in chain.ranges:
        return
    (low, high), (least, most) = chain.ranges[name], chain.ranges[output]
    ways = "; fit a log that begins at rest, or hold it in the range of the log"
    beside = REST_MARGIN * (high - low)
    if not low - beside <= idle <= high + beside:
        raise ParameterError(
            f"Model `{chain.name}` would start in a steady state at {name} = {idle:.6g}, but its records hold {name} "
            f"from {low:.6g} to {high:.6g} alone{ways}."
        )
    room = most - least
    levels, outputs = static_curve(chain, min(idle, low), max(idle, high), CURVE)
    rest = float(operating_point(chain, idle).outputs[number])
    curve = [(u, y, 1.0) for u, y in zip(levels, outputs[:, number].tolist(), strict=True)]
    for level, y, margin in ((idle, rest, REST_MARGIN), *curve):
        if not least - margin * room <= y <= most + margin * room:
            raise ParameterError(
                f"Model `{chain.name}` rests at {output} = {y:.4g} under {name} = {level:.4g}, but its records hold "
                f"{output} from {least:.4g} to {most:.4g}: its static curve leaves what was measured{ways}."
            )
    for target in targets:
        if not least - REST_MARGIN * room <= rest + target <= most + REST_MARGIN * room:
            raise ParameterError(
                f"Model `{chain.name}` is to reach {output} = {rest + target:.4g}, but its records hold {output} "
                f"from {least:.4g} to {most:.4g} alone."
            )
