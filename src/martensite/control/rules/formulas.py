"""Tuning rules: PI and PID gains from a model of first order with dead time.

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

with x = L/T. The wanted time of the closed loop is τ_c of SIMC (default L, L/2 for PID) or λ (default T). Rules for an
integrating plant are the limits for a large T with K/T = k', if the source gives one: written in L and x they hold for
both. A negative gain of the plant gives negative gains.

A sampled controller holds its signal, which is late by half a period on average: `gains_by_rule` adds it to the dead
time.

Sources: `ziegler1942`, `chien1952`, `cohen1953`, `skogestad2003`, `grimholt2018` (PID of SIMC), `astrom2004` (AMIGO),
`dahlin1968` and `rivera1986` (lambda).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.controllers.pid import Gains, compute_gains_per_sample

FORMS = ("pi", "pid")


class FirstOrder(NamedTuple):
    """A plant of first order with dead time."""

    gain: float
    """K, in units of the reading per signal."""
    time_constant: float
    """T [s]."""
    dead_time: float
    """L [s]."""

    @property
    def rate(self) -> float:
        """Return k' = K/T, the initial rate per signal."""
        return self.gain / self.time_constant


class Integrating(NamedTuple):
    """An integrating plant with dead time."""

    rate: float
    """k', in units of the reading per second and signal."""
    dead_time: float
    """L [s]."""


class IdealGains(NamedTuple):
    """Gains of K_p (1 + 1/(T_i s) + T_d s)."""

    Kp: float
    Ti: float
    """Integral time [s]; infinite without an integral part."""
    Td: float = 0.0
    """Derivative time [s]."""

    @property
    def Ki(self) -> float:
        """Return K_p/T_i [1/s]."""
        return self.Kp / self.Ti

    @property
    def Kd(self) -> float:
        """Return K_p T_d [s]."""
        return self.Kp * self.Td

    def per_second(self) -> Gains:
        """Return K_p, K_i [1/s] and K_d [s] of K_p + K_i/s + K_d s."""
        return Gains(self.Kp, self.Ki, self.Kd)

    def per_sample(self, interval: float) -> Gains:
        """Return the gains per sample of `interval` [s]."""
        return compute_gains_per_sample(self.Kp, self.Ki, self.Kd, interval)


Model = FirstOrder | Integrating
Formula = Callable[[float, float, float | None], IdealGains]
"""Gains from (dead time L [s], x = L/T, wanted time of the loop [s]) for K/T = 1."""


class Rule(NamedTuple):
    """A tuning rule."""

    cites: tuple[str, ...]
    pi: Formula
    pid: Formula
    integrating: bool = False
    """True if the source gives the rule for an integrating plant."""
    aimed: bool = False
    """True if the rule takes a wanted time of the loop."""


def convert_series(Kp: float, Ti: float, Td: float) -> IdealGains:
    """Return the controller K_p (1 + 1/(T_i s)) (1 + T_d s) as a sum."""
    both = 1.0 + Td / Ti
    return IdealGains(Kp * both, Ti * both, Td / both)


def _apply_simc(L: float, x: float, aim: float) -> tuple[float, float]:
    """Return K_p and T_i of the controller, for PID in series."""
    late = aim + L
    return 1.0 / late, min(L / x, 4.0 * late) if x else 4.0 * late


RULES: Mapping[str, Rule] = {
    "ziegler-nichols": Rule(
        ("ziegler1942",),
        lambda L, x, aim: IdealGains(0.9 / L, L / 0.3),
        lambda L, x, aim: IdealGains(1.2 / L, 2.0 * L, 0.5 * L),
        integrating=True,
    ),
    "chien-hrones-reswick": Rule(
        ("chien1952",),
        lambda L, x, aim: IdealGains(0.35 / L, 1.2 * L / x),
        lambda L, x, aim: IdealGains(0.6 / L, L / x, 0.5 * L),
    ),
    "chien-hrones-reswick-20": Rule(
        ("chien1952",),
        lambda L, x, aim: IdealGains(0.6 / L, L / x),
        lambda L, x, aim: IdealGains(0.95 / L, 1.4 * L / x, 0.47 * L),
    ),
    "cohen-coon": Rule(
        ("cohen1953",),
        lambda L, x, aim: IdealGains((0.9 + x / 12.0) / L, L * (30.0 + 3.0 * x) / (9.0 + 20.0 * x)),
        lambda L, x, aim: IdealGains(
            (4.0 / 3.0 + x / 4.0) / L, L * (32.0 + 6.0 * x) / (13.0 + 8.0 * x), 4.0 * L / (11.0 + 2.0 * x)
        ),
    ),
    "simc": Rule(
        ("skogestad2003", "grimholt2018"),
        lambda L, x, aim: IdealGains(*_apply_simc(L, x, L if aim is None else aim)),
        lambda L, x, aim: convert_series(*_apply_simc(L, x, 0.5 * L if aim is None else aim), L / 3.0),
        integrating=True,
        aimed=True,
    ),
    "amigo": Rule(
        ("astrom2004",),
        lambda L, x, aim: IdealGains(
            (0.15 * x + 0.35 - x / (1.0 + x) ** 2) / L, 0.35 * L + 13.0 * L / (1.0 + 12.0 * x + 7.0 * x**2)
        ),
        lambda L, x, aim: IdealGains((0.2 * x + 0.45) / L, L * (0.4 * x + 0.8) / (x + 0.1), 0.5 * L / (0.3 * x + 1.0)),
        integrating=True,
    ),
    "lambda": Rule(
        ("dahlin1968", "rivera1986"),
        lambda L, x, aim: IdealGains(1.0 / ((L / x if aim is None else aim) + L), L / x),
        lambda L, x, aim: IdealGains(
            (1.0 + 0.5 * x) / ((L / x if aim is None else aim) + 0.5 * L), L / x + 0.5 * L, L / (2.0 + x)
        ),
        aimed=True,
    ),
}


def gains_by_rule(
    model: Model, rule: str, form: str = "pid", *, aim: float | None = None, period: float = 0.0
) -> IdealGains:
    """Return the gains by a rule.

    Args:
        model: plant, for example from a step test.
        rule: name in `RULES`.
        form: pi or pid.
        aim: wanted time of the closed loop [s], for `simc` (τ_c) and `lambda` (λ).
        period: period of a sampled controller [s]; half of it counts as dead time.

    Raises:
        ParameterError: an unknown rule or form, a plant without dead time or gain, or a rule without an integrating
            form.
    """
    if rule not in RULES:
        raise ParameterError(f"There is no tuning rule `{rule}`. {suggest_name(rule, RULES)}")
    if form not in FORMS:
        raise ParameterError(f"A rule gives `pi` or `pid`, not `{form}`. {suggest_name(form, FORMS)}")
    if aim is not None and not (RULES[rule].aimed and aim > 0.0):
        raise ParameterError(
            f"A time wanted of the loop must be above 0 s and is for `simc` and `lambda`, but is "
            f"{aim:g} s for `{rule}`."
        )
    late = model.dead_time + 0.5 * period
    first_order = isinstance(model, FirstOrder)
    sizes = (model.gain, model.time_constant) if first_order else (model.rate,)
    if not (late > 0.0 and all(math.isfinite(size) and size != 0.0 for size in sizes)):
        raise ParameterError(
            "A tuning rule needs a plant with a gain, a time constant and a dead time above 0 s; "
            "give the period of the controller, half of which counts as dead time."
        )
    if not (first_order or RULES[rule].integrating):
        raise ParameterError(f"Rule `{rule}` is not for an integrating plant.")
    x = late / model.time_constant if first_order else 0.0
    gains = getattr(RULES[rule], form)(late, x, aim)
    return gains._replace(Kp=gains.Kp / model.rate)
