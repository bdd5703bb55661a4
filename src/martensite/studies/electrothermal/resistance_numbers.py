"""Numbers of R(ξ, T) of run 5: two fits, and their limits."""

from __future__ import annotations

from functools import cache

from martensite.fit.profiling import profile_likelihood
from martensite.search.profile import Profile
from martensite.studies.electrothermal import heating_fit as heating
from martensite.studies.electrothermal import model, record
from martensite.studies.electrothermal import resistance_fit as fitting
from martensite.studies.readings import ZERO
from martensite.studies.tables import Printed


@cache
def strip_profile(name: str, offset: float) -> Profile:
    """Return the profile of A_s or A_f with the plain mixture."""
    return profile_likelihood(fitting.fit_shape("mixture", offset), name)


def compute_resistance(stated: Printed) -> dict[str, float]:
    """Return resistivities, offset and place of the drop; shapes of R; then the electrical fit."""
    numbers = {
        "lower": fitting.LOWER,
        "upper": fitting.UPPER,
        "rho_difference": stated.rho_M - stated.rho_A,
        "rise_percent": 100.0 * stated.rise,
    }
    if not record.has_files(record.UNTRAINED, record.WARMTH):
        return numbers
    return numbers | compute_fits(stated) | compute_shapes(stated) | compute_films(stated)


def compute_fits(stated: Printed) -> dict[str, float]:
    """Return resistivities, their difference at three offsets, and the offset."""
    fit = fitting.fit_shape("mixture", stated.offset)
    offsets = {"": stated.offset, "_lower": fitting.LOWER, "_upper": fitting.UPPER}
    differences = {
        f"fit_difference{shape_name}{name}": fitting.resistivity_difference(fitting.fit_shape(shape, offset))[0]
        for shape, shape_name in (("mixture", ""), ("both", "_slopes"))
        for name, offset in offsets.items()
    }
    return differences | {
        "fit_rho_austenite": fit["rho_A"],
        "fit_rho_martensite": fit["rho_M"],
        "fit_rms": fitting.residual_rms(fit),
        "fit_held_out": fitting.residual_rms(fit, "held-out"),
        "fit_offset": fitting.offset_of("mixture").value,
        "fit_offset_slope": fitting.offset_of("austenite").value,
        "fit_offset_slopes": fitting.offset_of("both").value,
        "heated_offset": heating.offset_found().value,
        "fit_strip_start": strip_profile("A_s", stated.offset).interval[0] - ZERO,
        "fit_strip_end": strip_profile("A_f", stated.offset).interval[1] - ZERO,
        "fit_between": float(fitting.count_transforming(fit)),
    }


def compute_shapes(stated: Printed) -> dict[str, float]:
    """Return the improvement by a resistance that grows with temperature."""
    fits = {name: fitting.fit_shape(name, stated.offset) for name in ("mixture", "austenite", "both")}
    plain = fitting.akaike_criterion(fits["mixture"])
    errors = {f"left_out_{name}": fitting.predicted_rms(name, stated.offset) for name in fits}
    return errors | {
        "fit_rise": 4000.0 * fits["austenite"]["a_rho_A"],
        "aicc_austenite": fitting.akaike_criterion(fits["austenite"]) - plain,
        "aicc_both": fitting.akaike_criterion(fits["both"]) - plain,
        "geometry": 100.0 * fitting.stretch_share(model.read_number("eps_L")),
    }


def compute_films(stated: Printed) -> dict[str, float]:
    """Return film coefficient and resistivity difference of the electrical fit."""
    heated, films = heating.fit_heating(stated.offset), heating.apparent_films(stated.offset)
    return {
        "heated_film": heated["h"],
        "heated_difference": fitting.resistivity_difference(heated)[0],
        "camera_film_cold": films[0],
        "camera_film_hot": films[-1],
    }
