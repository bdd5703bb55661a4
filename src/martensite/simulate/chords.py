"""Distance between a curve and the straight lines through its nodes.

A step has the nodes 1, 2, 3; the nodes 0 and 4 are half a step before and after it. The curve may have a corner
between two nodes, as at the start of a transformation. The lines through the node pairs on both sides intersect at
the corner. Their height is two to four times the height of a smooth curve. Without an intersection in the gap, a
parabola of twice the height is used.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
Flags = NDArray[np.bool_]


def bend_chords(times: Numbers, values: Numbers, joined: Flags, shares: Numbers) -> Numbers:
    """Return the distance of a curve from the lines between the nodes 1, 2 and 3.

    Args:
        times: of the nodes [s], (steps, 5).
        values: columns at the nodes, (steps, 5, columns).
        joined: whether the nodes 0 and 4 belong to the same smooth stretch, (steps, 2).
        shares: places in the steps from 0 to 1, (steps, places).

    Returns:
        Signed distance from the line, (steps, places, columns).
    """
    lengths = np.diff(times, axis=1)
    lengths = np.where(lengths > 0.0, lengths, np.inf)
    slopes = np.diff(values, axis=1) / lengths[:, :, None]
    falls = -np.diff(slopes, axis=1)[:, None] * lengths[:, None, 1:2, None]  # at the nodes 1, 2, 3, over half a step
    late = (shares > 0.5)[:, :, None]
    share = (2.0 * shares - (shares > 0.5))[:, :, None]
    before, after = (np.where(late, falls[:, :, k + 1], falls[:, :, k]) for k in (0, 1))
    left, right = before * share, after * (1.0 - share)
    tent = np.sign(left) * np.minimum(np.abs(left), np.abs(right))
    parabola = share * (1.0 - share) * falls[:, :, 1]
    has_neighbour = np.where(late, joined[:, None, 1:], joined[:, None, :1])
    return np.where(has_neighbour & (left * right > 0.0), tent, parabola)
