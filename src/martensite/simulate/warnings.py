"""What a run must warn about: exceeded limits, slack, coarse steps; with time and amount."""

from __future__ import annotations

from martensite.simulate.result import Result
from martensite.status import Status


def warnings_of(result: Result) -> list[str]:
    """All warnings of a run, as sentences."""
    limits = result.system.element.limits
    found = [
        _above(result, "temperature", limits.temperature_limit, "temperature_limit", 273.15, "°C"),
        _above(result, "stress", limits.stress_limit, "stress_limit", 0.0, "MPa", 1e6),
        _strain(result, limits.strain_limit),
        _slack(result),
    ]
    if result.status is Status.LONG_STEP:
        found.append(f"Warning: {result.status.sentence}")
    return [sentence for sentence in found if sentence]


def _above(
    result: Result, name: str, limit: float, parameter: str, zero: float, unit: str,
    scale: float = 1.0,
) -> str:  # fmt: skip
    worst = max(result[name])
    if worst <= limit:
        return ""
    first = next(t for t, v in zip(result.times, result[name], strict=True) if v > limit)
    return (
        f"Warning: {name} reaches {(worst - zero) / scale:.4g} {unit}, above the "
        f"`{parameter}` of {(limit - zero) / scale:.4g} {unit}, first at t = {first:.4g} s."
    )


def _strain(result: Result, limit: float) -> str:
    amplitude = result.range("strain")
    if amplitude <= limit:
        return ""
    return (
        f"Warning: strain varies by {100 * amplitude:.3g} %, more than the "
        f"`strain_limit` of {100 * limit:.3g} %."
    )


def _slack(result: Result) -> str:
    pulled = result["force"][0] > 0.0
    first = next((t for t, f in zip(result.times, result["force"], strict=True) if f <= 0.0), None)
    if not pulled or first is None:
        return ""
    return f"Warning: the element is slack (no force), first at t = {first:.4g} s."
