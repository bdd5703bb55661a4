"""Laws with one fraction and two strips, with the strips of problem A and their closed forms."""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import pytest
from builders import LAW_A
from closed_forms import A_F, A_S, C_A, C_M, M_F, M_S

from martensite.physics.laws.strip_laws import Elahinia, LiangRogers, Tanaka

NUMBERS: dict[str, Any] = LAW_A | {"Theta": 0.0}


class Case(NamedTuple):
    """A law, and what a process leaves after a share of its strip (0 start, 1 finish line)."""

    cls: type
    left: Callable[[float], float]
    options: Mapping[str, str] = MappingProxyType({})

    def law(self, rule="resume", **changes):
        return self.cls(**(NUMBERS | changes), history=rule, **self.options)

    def cold(self, celsius, mpa=0.0):
        """What cooling (or loading) from above M_s leaves of all austenite."""
        return self.left(max(0.0, (M_S - celsius + mpa / C_M) / (M_S - M_F)))

    def hot(self, celsius, mpa=0.0):
        """What heating (or unloading) from below A_s leaves of all martensite."""
        return self.left(max(0.0, (celsius - mpa / C_A - A_S) / (A_F - A_S)))


def cosine(share):
    return math.cos(0.5 * math.pi * min(share, 1.0)) ** 2 if share < 1.0 else 0.0


def exponential(share):
    return math.exp(-2.0 * math.log(10.0) * share)


CASES = {
    **{f"liang-rogers {m}": Case(LiangRogers, cosine, {"modulus": m}) for m in ("austenite", "martensite", "mixture")},
    "elahinia": Case(Elahinia, cosine),
    **{f"tanaka {m}": Case(Tanaka, exponential, {"modulus": m}) for m in ("austenite", "martensite")},
}
EVERY = pytest.mark.parametrize("case", CASES.values(), ids=CASES)
KINETICS = pytest.mark.parametrize(
    "case",
    [CASES[name] for name in ("liang-rogers austenite", "elahinia", "tanaka austenite")],
    ids=["liang-rogers", "elahinia", "tanaka"],
)
