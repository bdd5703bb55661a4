r"""Tuning rules: PI and PID gains from a model of first order with dead time.

    G(s) = K e^(-L s)/(1 + T s)         rate k' = K/T;      integrating: k' e^(-L s)/s

    C(s) = K_p (1 + 1/(T_i s) + T_d s)

    rule                   form  K_p K               T_i                     T_d
    ziegler-nichols        PI    0.9 T/L             L/0.3
                           PID   1.2 T/L             2 L                     L/2
    chien-hrones-reswick   PI    0.35 T/L            1.2 T
    (set point, 0 %)       PID   0.6 T/L             T                       L/2
    chien-hrones-reswick-20  PI  0.6 T/L             T
    (set point, 20 %)      PID   0.95 T/L            1.4 T                   0.47 L
    cohen-coon             PI    T/L (0.9 + x/12)    L (30 + 3 x)/(9 + 20 x)
                           PID   T/L (4/3 + x/4)     L (32 + 6 x)/(13 + 8 x)   4 L/(11 + 2 x)
    simc                   PI    T/(τ_c + L)         min(T, 4 (τ_c + L))
                           PID   the same in series with 1 + s L/3, τ_c = L/2
    amigo                  PI    0.15 + (0.35 - L T/(L + T)²) T/L
                                                     0.35 L + 13 L T²/(T² + 12 L T + 7 L²)
                           PID   0.2 + 0.45 T/L      L (0.4 L + 0.8 T)/(L + 0.1 T)
                                                                             L T/2/(0.3 L + T)
    lambda                 PI    T/(λ + L)           T
                           PID   (T + L/2)/(λ + L/2) T + L/2                 L T/(2 T + L)

with x = L/T. The time wanted of the closed loop is τ_c of SIMC (L by default, L/2 for PID) or λ
(T by default). Rules for an integrating plant are their limits for a large T with K/T = k', where
the sources have one. A gain of the plant below 0 gives gains below 0.

A sampled controller holds its signal, which is late by half a period on average: give it to
`gains_by_rule` as part of the dead time.

Sources: `ziegler1942`, `chien1952`, `cohen1953`, `skogestad2003`, `grimholt2018` (PID of SIMC),
`astrom2004` (AMIGO), `dahlin1968` and `rivera1986` (lambda).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.controllers.pid import Gains, per_sample

FORMS = ("pi", "pid")


class FirstOrder(NamedTuple):
    """A plant of first order with dead time."""

    gain: float
    """K, in the unit of what is measured per signal."""
    time_constant: float
    """T [s]"""
    dead_time: float
    """L [s]"""

    @property
    def rate(self) -> float:
        """k' = K/T: how fast it goes at first, per signal."""
        return self.gain / self.time_constant


class Integrating(NamedTuple):
    """A plant that goes on as long as there is a signal, with dead time."""

    rate: float
    """k', in the unit of what is measured per second and signal."""
    dead_time: float
    """L [s]"""


class IdealGains(NamedTuple):
    """K_p (1 + 1/(T_i s) + T_d s) found by a rule."""

    Kp: float
    Ti: float
    """Integral time [s]; infinite without an integral part."""
    Td: float = 0.0
    """Derivative time [s]."""

    @property
    def Ki(self) -> float:
        """K_p/T_i: gain of the integral [1/s]."""
        return self.Kp / self.Ti

    @property
    def Kd(self) -> float:
        """K_p T_d: gain of the derivative [s]."""
        return self.Kp * self.Td

    def per_second(self) -> Gains:
        """K_p, K_i [1/s] and K_d [s] of K_p + K_i/s + K_d s."""
        return Gains(self.Kp, self.Ki, self.Kd)

    def per_sample(self, interval: float) -> Gains:
        """Gains per sample of `interval` [s], as in `martensite.control.controllers.pid`."""
        return per_sample(self.Kp, self.Ki, self.Kd, interval)


Model = FirstOrder | Integrating


class Rule(NamedTuple):
    """A rule; its functions take the form, the plant, and the time wanted of the loop."""

    cites: tuple[str, ...]
    first_order: Callable[[str, float, float, float | None], IdealGains]
    """Of (form, T, L, time wanted [s]), for K = 1."""
    integrating: Callable[[str, float, float | None], IdealGains] | None = None
    """Of (form, L, time wanted [s]), for k' = 1; None if the source has none."""
    aimed: bool = False
    """Whether a time can be wanted of the loop."""


def convert_series(Kp: float, Ti: float, Td: float) -> IdealGains:
    """The controller K_p (1 + 1/(T_i s)) (1 + T_d s) as a sum."""
    both = 1.0 + Td / Ti
    return IdealGains(Kp * both, Ti * both, Td / both)


def _ziegler_nichols(form: str, L: float, aim: float | None) -> IdealGains:
    return IdealGains(0.9 / L, L / 0.3) if form == "pi" else IdealGains(1.2 / L, 2.0 * L, 0.5 * L)


def _ziegler_first(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    found = _ziegler_nichols(form, L, aim)
    return found._replace(Kp=T * found.Kp)


def _chien_hrones(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    return (
        IdealGains(0.35 * T / L, 1.2 * T) if form == "pi" else IdealGains(0.6 * T / L, T, 0.5 * L)
    )


def _chien_20(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    return (
        IdealGains(0.6 * T / L, T) if form == "pi" else IdealGains(0.95 * T / L, 1.4 * T, 0.47 * L)
    )


def _cohen_coon(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    x = L / T
    if form == "pi":
        return IdealGains((0.9 + x / 12.0) / x, L * (30.0 + 3.0 * x) / (9.0 + 20.0 * x))
    return IdealGains(
        (4.0 / 3.0 + x / 4.0) / x,
        L * (32.0 + 6.0 * x) / (13.0 + 8.0 * x),
        4.0 * L / (11.0 + 2.0 * x),
    )


def _simc_aim(form: str, L: float, aim: float | None) -> float:
    return (L if form == "pi" else 0.5 * L) if aim is None else aim


def _simc(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    late = _simc_aim(form, L, aim) + L
    Kp, Ti = T / late, min(T, 4.0 * late)
    return IdealGains(Kp, Ti) if form == "pi" else convert_series(Kp, Ti, L / 3.0)


def _simc_integrating(form: str, L: float, aim: float | None) -> IdealGains:
    late = _simc_aim(form, L, aim) + L
    return (
        IdealGains(1.0 / late, 4.0 * late)
        if form == "pi"
        else convert_series(1.0 / late, 4.0 * late, L / 3)
    )


def _amigo(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    if form == "pi":
        Kp = 0.15 + (0.35 - L * T / (L + T) ** 2) * T / L
        return IdealGains(Kp, 0.35 * L + 13.0 * L * T**2 / (T**2 + 12.0 * L * T + 7.0 * L**2))
    Ti = L * (0.4 * L + 0.8 * T) / (L + 0.1 * T)
    return IdealGains(0.2 + 0.45 * T / L, Ti, 0.5 * L * T / (0.3 * L + T))


def _amigo_integrating(form: str, L: float, aim: float | None) -> IdealGains:
    return (
        IdealGains(0.35 / L, 13.35 * L) if form == "pi" else IdealGains(0.45 / L, 8.0 * L, 0.5 * L)
    )


def _lambda(form: str, T: float, L: float, aim: float | None) -> IdealGains:
    wanted = T if aim is None else aim
    if form == "pi":
        return IdealGains(T / (wanted + L), T)
    return IdealGains((T + 0.5 * L) / (wanted + 0.5 * L), T + 0.5 * L, L * T / (2.0 * T + L))


RULES: Mapping[str, Rule] = {
    "ziegler-nichols": Rule(("ziegler1942",), _ziegler_first, _ziegler_nichols),
    "chien-hrones-reswick": Rule(("chien1952",), _chien_hrones),
    "chien-hrones-reswick-20": Rule(("chien1952",), _chien_20),
    "cohen-coon": Rule(("cohen1953",), _cohen_coon),
    "simc": Rule(("skogestad2003", "grimholt2018"), _simc, _simc_integrating, aimed=True),
    "amigo": Rule(("astrom2004",), _amigo, _amigo_integrating),
    "lambda": Rule(("dahlin1968", "rivera1986"), _lambda, aimed=True),
}
"""Rules by name."""


def gains_by_rule(
    model: Model, rule: str, form: str = "pid", *, aim: float | None = None, period: float = 0.0
) -> IdealGains:
    """Gains by a rule.

    Args:
        model: the plant, such as a step test finds it.
        rule: its name in `RULES`.
        form: pi or pid.
        aim: time wanted of the closed loop [s], for `simc` (τ_c) and `lambda` (λ).
        period: of a sampled controller [s]; half of it counts as dead time.

    Raises:
        ParameterError: an unknown rule or form, a plant without dead time or gain, or a rule that
            has nothing for an integrating plant.
    """
    if rule not in RULES:
        raise ParameterError(f"There is no tuning rule `{rule}`. {suggest_name(rule, RULES)}")
    if form not in FORMS:
        raise ParameterError(
            f"A rule gives `pi` or `pid`, not `{form}`. {suggest_name(form, FORMS)}"
        )
    if aim is not None and not (RULES[rule].aimed and aim > 0.0):
        raise ParameterError(
            f"A time wanted of the loop must be above 0 s and is for `simc` and `lambda`, but is "
            f"{aim:g} s for `{rule}`."
        )
    late = model.dead_time + 0.5 * period
    _require_rule(model, late)
    if isinstance(model, FirstOrder):
        found = RULES[rule].first_order(form, model.time_constant, late, aim)
        return found._replace(Kp=found.Kp / model.gain)
    law = RULES[rule].integrating
    if law is None:
        raise ParameterError(f"Rule `{rule}` is not for an integrating plant.")
    found = law(form, late, aim)
    return found._replace(Kp=found.Kp / model.rate)


def _require_rule(model: Model, late: float) -> None:
    """Raise `ParameterError` for a plant that no rule is for."""
    sizes = (model.rate,) if isinstance(model, Integrating) else (model.gain, model.time_constant)
    if not (late > 0.0 and all(math.isfinite(size) and size != 0.0 for size in sizes)):
        raise ParameterError(
            "A tuning rule needs a plant with a gain, a time constant and a dead time above 0 s; "
            "give the period of the controller, half of which counts as dead time."
        )
