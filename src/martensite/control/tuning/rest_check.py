"""Check that the steady states of a model that a controller is tuned on lie within its records."""

from __future__ import annotations

from collections.abc import Sequence

from martensite.base.errors import ParameterError
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.linearise import operating_point, static_curve

REST_MARGIN = 0.25
"""Share of a range by which a model may be at rest beside it, and still be designed on."""
CURVE = 21
"""Points of a static curve that is checked."""


def check_static_curve(chain: Chain, idle: float, targets: Sequence[float] = (), number: int = -1) -> None:
    """Raise `ParameterError` if a model is at rest where its records never were.

    A controller that is designed on such a model is designed on what nothing was measured of. The idle input is that
    before it is controlled, targets of the output are counted from where it rests then; a model of several inputs, or
    one that does not know the ranges of its records, is not checked.
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
    for level, y, share in ((idle, rest, REST_MARGIN), *curve):
        if not least - share * room <= y <= most + share * room:
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
