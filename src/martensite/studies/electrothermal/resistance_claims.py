"""Claims on what run 5 says about R(ξ, T): two ways to fit it, and what neither can tell."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from martensite.identify.fitting.profiled import profiled
from martensite.identify.fitting.profiles import Profile
from martensite.studies.base import Claim
from martensite.studies.electrothermal import heating_fit as heating
from martensite.studies.electrothermal import model, record
from martensite.studies.electrothermal import resistance_fit as fitting
from martensite.studies.electrothermal.checks import PROGRAM, RUN_5, Check, settle
from martensite.studies.electrothermal.printed import Stated

RESISTIVITY = "uohm cm"
_SCALE = 1e8
READ = "fit of all plateaus but every fifth, offset of the authors; the material's number was read "
READ += "off this record too, and the tolerance is what it says the offset makes of it"


def claims(stated: Stated) -> list[Claim]:
    """Resistivities, offset and place of the drop; shapes of R; then the electrical way."""
    checks = [
        *_resistivities(stated), *_differences(stated), *_offsets(stated), *_strip(stated),
        *_shapes(stated), *_films(stated),
    ]  # fmt: skip
    return settle(checks, record.UNTRAINED, record.WARMTH)


@cache
def strip_profile(name: str, offset: float) -> Profile:
    """Profile of A_s or A_f with the plain mixture."""
    return profiled(fitting.fitted("mixture", offset), name)


def _report(id: str, statement: str, unit: str, why: str, value: Callable[[], float]) -> Check:
    return Check(id, statement, RUN_5, None, unit, None, why, value)


def _resistivities(stated: Stated) -> list[Check]:
    def fit():
        return fitting.fitted("mixture", stated.offset)

    return [
        Check(
            "fit-rho-austenite", "fit: resistivity of austenite", RUN_5, _SCALE * stated.rho_A,
            RESISTIVITY, 2.0, READ, lambda: _SCALE * fit()["rho_A"],
        ),
        Check(
            "fit-rho-martensite", "fit: resistivity of martensite", RUN_5, _SCALE * stated.rho_M,
            RESISTIVITY, 4.0, READ, lambda: _SCALE * fit()["rho_M"],
        ),
        _report(
            "fit-rms", "R of the fit less measured, rms", "ohm", "the plateaus it has seen",
            lambda: fitting.rms(fit()),
        ),
        _report(
            "fit-held-out", "the same on the plateaus kept back", "ohm",
            "six plateaus; larger because of one of them, 2.2 V, where R is highest",
            lambda: fitting.rms(fit(), "held-out"),
        ),
    ]  # fmt: skip


def _differences(stated: Stated) -> list[Check]:
    def found(shape: str, offset: float) -> float:
        return _SCALE * fitting.difference(fitting.fitted(shape, offset))[0]

    def check(id: str, words: str, why: str, shape: str, offset: float) -> Check:
        statement = f"fit: ρ_M - ρ_A, {words}"
        return _report(id, statement, RESISTIVITY, why, lambda: found(shape, offset))

    lower, upper, both = fitting.LOWER, fitting.UPPER, "ρ_A and ρ_M grow with temperature"
    return [
        check(
            "fit-difference", "plain mixture, offset of the authors",
            "mean over all cold plateaus less mean over all hot ones", "mixture", stated.offset,
        ),
        check(
            "fit-difference-lower", f"plain mixture, offset {lower:g} V",
            "what the record has from 1.3 to 2.2 V", "mixture", lower,
        ),
        check(
            "fit-difference-upper", f"plain mixture, offset {upper:g} V",
            "what it has from 1.3 to 2.0 V: the offset moves the difference by more than the "
            "scatter does", "mixture", upper,
        ),
        Check(
            "fit-difference-slopes", f"fit: ρ_M - ρ_A, {both}, offset of the authors", RUN_5,
            _SCALE * (stated.rho_M - stated.rho_A), RESISTIVITY, 2.3,
            "at 67 °C, on both sides of the drop; the tolerance is half of its 95 % interval. The "
            "material's numbers are from this record too", lambda: found("both", stated.offset),
        ),
        check(
            "fit-difference-slopes-lower", f"{both}, offset {lower:g} V",
            "an offset tilts both branches and leaves the step between them", "both", lower,
        ),
        check(
            "fit-difference-slopes-upper", f"{both}, offset {upper:g} V", "the same", "both", upper,
        ),
    ]  # fmt: skip


def _offsets(stated: Stated) -> list[Check]:
    return [
        Check(
            "fit-offset", "set-point less voltage, fitted with the plain mixture", PROGRAM,
            stated.offset, "V", 0.07,
            "least squares over all plateaus, not over the cold ones alone; the tolerance is half "
            "of its 95 % interval", lambda: fitting.offset_of("mixture").value,
        ),
        Check(
            "fit-offset-slope", "the same, ρ_A grows with temperature", PROGRAM, stated.offset,
            "V", 0.07, "same tolerance", lambda: fitting.offset_of("austenite").value,
        ),
        _report(
            "fit-offset-slopes", "the same, ρ_A and ρ_M grow with temperature", "V",
            "with a martensite that grows by 0.4 % per kelvin; the interval is 0.2 to 0.5 V: free "
            "slopes and the offset make up for each other",
            lambda: fitting.offset_of("both").value,
        ),
        Check(
            "heated-offset", "the same from the current of a wire heated by voltage", PROGRAM,
            stated.offset, "V", 0.12, "half of its 95 % interval",
            lambda: heating.offset_found().value,
        ),
    ]  # fmt: skip


def _strip(stated: Stated) -> list[Check]:
    offset = stated.offset

    def celsius(name: str, end: int) -> float:
        return strip_profile(name, offset).interval[end] - model.ZERO

    return [
        _report(
            "fit-strip-start", "apparent A_s, at least", "degC",
            "95 %, profile; from above only by the plateau of 2.3 V: only one combination of A_s "
            "and A_f is determined", lambda: celsius("A_s", 0),
        ),
        _report(
            "fit-strip-end", "apparent A_f, at most", "degC",
            "95 %, profile; from below only by the plateau of 2.3 V; the material has 76.8 °C",
            lambda: celsius("A_f", 1),
        ),
        _report(
            "fit-between", "plateaus on which the fitted wire is transforming", "plateaus",
            "at 2.3 V; no other shape of R(ξ) can be told from the straight one, for the strip "
            "makes up for it, and nothing else says what ξ was",
            lambda: float(fitting.between(fitting.fitted("mixture", offset))),
        ),
    ]  # fmt: skip


def _shapes(stated: Stated) -> list[Check]:
    offset = stated.offset

    def better(shape: str) -> float:
        found, plain = (fitting.fitted(name, offset) for name in (shape, "mixture"))
        return fitting.criterion(found) - fitting.criterion(plain)

    return [
        Check(
            "fit-rise", "fit: rise of the resistance of austenite per 40 K", RUN_5,
            100.0 * stated.rise, "%", 0.5,
            "of apparent temperature; its interval holds zero with the offset of the authors, and "
            "no longer does with 0.27 V",
            lambda: 4000.0 * fitting.fitted("austenite", offset)["a_rho_A"],
        ),
        *(
            _report(
                f"aicc-{shape}", f"AICc less that of the plain mixture: {words}", "1",
                "negative where it is better; a difference below 4 tells little, autocorrelated "
                "residuals less", lambda shape=shape: better(shape),
            )
            for shape, words in (("austenite", "ρ_A grows"), ("both", "ρ_A and ρ_M grow"))
        ),
        *(
            _report(
                f"left-out-{shape}", f"predicted R less measured, rms: {words}", "ohm",
                "31 plateaus, each kept back once", lambda shape=shape: fitting.predicted_rms(
                    shape, offset
                ),
            )
            for shape, words in (
                ("mixture", "plain mixture"), ("austenite", "ρ_A grows with temperature"),
                ("both", "ρ_A and ρ_M grow"),
            )
        ),
        _report(
            "geometry", "rise of R that the stretch by ε_L makes alone, (1 + ε)/(1 - ν ε)² - 1",
            "%", "ε_L of the material, ν of the maker's sheet. If this wire shortened by ε_L when "
            "heated, and its length is not on record, nearly all of the drop is geometry: ρ_M and "
            "ε_L make up for each other", lambda: 100.0 * fitting.stretch(model.number("eps_L")),
        ),
    ]  # fmt: skip


def _films(stated: Stated) -> list[Check]:
    return [
        _report(
            "heated-film", "apparent h from voltage and current, A_s and A_f of the material",
            "W/(m^2 K)", "known only by the current at which the resistance falls; more than five "
            "times free convection", lambda: heating.heated(stated.offset)["h"],
        ),
        _report(
            "heated-difference", "ρ_M - ρ_A from voltage and current", RESISTIVITY,
            "same plateaus, same shape: the same number as at the apparent temperature",
            lambda: _SCALE * fitting.difference(heating.heated(stated.offset))[0],
        ),
        _report(
            "camera-film-cold", "apparent h that closes the balance at 1.3 V", "W/(m^2 K)",
            "with the temperature of the camera",
            lambda: heating.apparent_films(stated.offset)[0],
        ),
        _report(
            "camera-film-hot", "the same at 4.5 V", "W/(m^2 K)",
            "it doubles on the way, which free convection does not: the camera reads a wire "
            "thinner than its pixel too cold, or heat leaves by other ways",
            lambda: heating.apparent_films(stated.offset)[-1],
        ),
    ]  # fmt: skip
