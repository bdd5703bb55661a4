"""Special functions as polynomials, which vectorise unlike library functions.

- sin(πx/2) on [0, 1] in odd powers of x up to x²¹; the truncation is below 2e-18.
- (1 + 2x) exp(x²) erfc(x) for x ≥ 0 in powers of t = (x - 3)/(x + 3), which maps the half line to [-1, 1]. Its
  Chebyshev
  series of degree 22 was computed for this project, with a relative error below 2e-15. Form: Shepherd and Laframboise
  (1981), Math. Comp. 36.
"""

from __future__ import annotations

import math

# in x with y = πx/2: the factor (π/2)^(2k+1) is folded into the Taylor terms
QUARTER_SINE = [(-1.0) ** k / math.factorial(2 * k + 1) * (math.pi / 2) ** (2 * k + 1) for k in range(11)]

ERFCX_CENTRE = 3.0
ERFCX = [
    1.2530080582697294,
    -0.13562110612457406,
    -0.04756229435341741,
    0.12964515870215676,
    -0.1192736634168011,
    0.06830802735903374,
    -0.02377051489165262,
    0.0025293916421329533,
    0.0018886901033398247,
    -0.000779831148538801,
    -0.00010515835710423451,
    0.00012509489322763638,
    4.94430061560518e-06,
    -2.008915566355881e-05,
    -7.192029177853296e-07,
    3.453213139050323e-06,
    3.372935825304925e-07,
    -5.955417449854396e-07,
    -1.2105519999749964e-07,
    8.727774343242349e-08,
    2.8088106773793708e-08,
    -7.56915596866748e-09,
    -3.2305251806974444e-09,
]


def evaluate_estrin(
    coefficients: list[float], times: str = "{} * {}", plus: str = "({} + {})", constant: str = "{!r}"
) -> tuple[list[tuple[str, str]], str]:
    """Return a polynomial in z in Estrin's form, as independent pairs of pairs.

    The result has the required powers, such as ("z2", "z * z"), and the text.
    """
    terms = [constant.format(c) for c in coefficients]
    powers: list[tuple[str, str]] = []
    power = "z"
    while len(terms) > 1:
        joined = [
            plus.format(terms[k], times.format(terms[k + 1], power)) if k + 1 < len(terms) else terms[k]
            for k in range(0, len(terms), 2)
        ]
        terms = joined
        if len(terms) > 1:
            name = f"z{2 ** (len(powers) + 1)}"
            powers.append((name, times.format(power, power)))
            power = name
    return powers, terms[0]
