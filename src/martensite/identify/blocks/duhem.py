"""Saturating hysteresis of Duhem type: a fraction z between 0 and 1 that follows two branches.

    (1 - z)/(1 - z₀) = (1 - F_r(x))/(1 - F_r(x₀)) for rising x,    z/z₀ = F_f(x)/F_f(x₀) for falling

F_r and F_f are sums of one or two logistic functions of the scaled input (`operators.branches`; Ivshin and Pence 1994).
Inner loops are scaled copies of the branches. Unlike plays it saturates, and both branches have their own shapes, as in
the transformation of a shape-memory alloy over temperature. The output is the fraction; a gain or a static block
follows.
"""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import Number, option, param
from martensite.identify.blocks.base import BLOCKS, AbstractRanged, Column, Numbers
from martensite.identify.operators import branches
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("duhem")
class Duhem(AbstractRanged):
    """Rate-independent fraction z; steps in one direction are exact.

    The initial z lies on the rising branch (`below`) or on the falling branch.
    """

    short = "duhem"
    shape = ("logistics",)
    cites = ("ivshin1994",)

    logistics: Number = param("1", "logistic functions per branch", low=1.0, high=2.0, default=2.0)
    history: str = option("direction of the input before the first sample", "below", "above", default="below")

    def numbers(self) -> tuple[str, ...]:
        count = int(self.logistics)
        return branches.name_branch("rising", count) + branches.name_branch("falling", count)

    def states(self) -> int:
        return 2

    def _branches(self, xp: Namespace, theta: Column) -> tuple[branches.LogisticBranch, branches.LogisticBranch]:
        half = len(theta) // 2
        return branches.branch_of(xp, theta[:half]), branches.branch_of(xp, theta[half:])

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        rising, falling = self._branches(xp, theta)
        r = self.unit(x[0])
        if self.history == "below":
            return r, branches.from_below(xp, rising, r)
        return r, branches.from_above(xp, falling, r)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        before, z = state
        rising, falling = self._branches(xp, theta)
        r = self.unit(x[0])
        z = branches.follow_leg(xp, rising, falling, r > before, before, z).fraction(xp, r)
        return (z,), (r, z)

    def start(self) -> Numbers:
        if int(self.logistics) == 1:
            return np.array([0.2, np.log(0.15), -0.2, np.log(0.15)])
        widths = np.log([0.1, 0.3])
        return np.array([0.2, 0.3, *widths, 1.0, -0.2, -0.3, *widths, 1.0])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        theta = self.start()
        count = int(self.logistics)
        middle, half = rng.uniform(-0.4, 0.4), rng.uniform(0.0, 0.5)
        for first, side in ((0, half), (len(theta) // 2, -half)):
            theta[first : first + count] = middle + side + rng.uniform(-0.15, 0.15, count)
            theta[first + count : first + 2 * count] += rng.uniform(-0.7, 0.7, count)
        return theta

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        half = self.half
        rows: list[tuple[str, float, str]] = []
        for name, value in zip(self.numbers(), map(float, theta), strict=True):
            if name.startswith("log_"):
                rows.append((name.removeprefix("log_"), half * float(np.exp(value)), "1"))
            elif name.endswith("logit"):
                share_name = name.removesuffix("logit") + "share"
                rows.append((share_name, float(1.0 / (1.0 + np.exp(-value))), "1"))
            else:
                rows.append((name, self.low + half * (1.0 + value), "1"))
        return rows
