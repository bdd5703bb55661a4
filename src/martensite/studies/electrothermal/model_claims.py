"""Claims on the model beside the record: without a fit, and with three calibrated numbers."""

from __future__ import annotations

from functools import cache

from martensite.studies.base import Claim
from martensite.studies.electrothermal import model, record
from martensite.studies.electrothermal.checks import RUN_5, Check, settle
from martensite.studies.electrothermal.model import Calibration
from martensite.studies.electrothermal.printed import Stated
from martensite.studies.electrothermal.record import Staircase

KEPT = (1.3, 4.5)
"""Plateaus that are compared: all but the three lowest [V]."""
CHOSEN = "chosen from this record; agreement says nothing"
FREE = "free convection from a horizontal wire; the record needs several times its h"
SHEET = "sheet F1140 has 80 and 100 uohm cm, the opposite order of what is measured"


def claims(stated: Stated) -> list[Claim]:
    """What needs no record first, then calibration and differences."""
    run = Staircase(stated)
    checks = [*_calibrated(run), *_differences(run)]
    return [*_unfitted(stated), *settle(checks, record.UNTRAINED, record.WARMTH)]


@cache
def calibration(stated: Stated) -> Calibration:
    """The three numbers that the record gives."""
    return model.calibrate(Staircase(stated))


def _unfitted(stated: Stated) -> list[Claim]:
    maker = model.predicted("maker", stated)
    start, end = model.span(maker)
    per_ohm = model.wire().length / model.wire().section()
    return [
        Claim.checked(
            "maker-martensite", "resistance of martensite, from the maker's sheet", RUN_5,
            stated.martensite_low, float(model.number("rho_M") * per_ohm), "ohm", 0.04, SHEET,
        ),
        Claim.checked(
            "maker-austenite", "resistance of austenite, from the maker's sheet", RUN_5,
            stated.austenite, float(model.number("rho_A") * per_ohm), "ohm", 0.04, SHEET,
        ),
        Claim.checked(
            "maker-start", "current at which the transformation starts, nothing fitted", RUN_5,
            stated.drop_start, start, "A", 0.1, FREE,
        ),
        Claim.checked(
            "maker-end", "current at which it is over, nothing fitted", RUN_5,
            stated.drop_end, end, "A", 0.1, FREE,
        ),
        *(
            Claim.reported(
                f"film-{name}", f"h of free convection half-way, {name} wire", RUN_5, film,
                "W/(m^2 K)", f"{law}; how the wire was mounted is not on record",
            )
            for name, law, film in zip(
                ("horizontal", "vertical"), ("Churchill and Chu", "LeFevre and Ede"),
                model.free_films(), strict=True,
            )
        ),
    ]  # fmt: skip


def _calibrated(run: Staircase) -> list[Check]:
    stated = run.stated

    def table():
        return model.predicted("calibrated", stated, calibration(stated))

    return [
        Check(
            "rho-martensite", "resistivity of martensite", RUN_5, 1e8 * stated.rho_M, "uohm cm",
            None, f"mean of 1.3 to 2.2 V; {CHOSEN}",
            lambda: 1e8 * calibration(stated).rho_M, calibrated=True,
        ),
        Check(
            "rho-austenite", "resistivity of austenite", RUN_5, 1e8 * stated.rho_A, "uohm cm",
            None, f"mean of 2.4 to 3.4 V; {CHOSEN}",
            lambda: 1e8 * calibration(stated).rho_A, calibrated=True,
        ),
        Check(
            "film", "apparent film coefficient", RUN_5, None, "W/(m^2 K)", None,
            "chosen to put half of the drop at its current; many times free convection, so not "
            "to be used for another wire: heat may leave by the clamps or with moving air",
            lambda: calibration(stated).h, calibrated=True,
        ),
        Check(
            "calibrated-start", "current at which the transformation starts", RUN_5,
            stated.drop_start, "A", None, "follows from the calibrated h",
            lambda: model.span(table())[0], calibrated=True,
        ),
        Check(
            "calibrated-end", "current at which it is over", RUN_5,
            stated.drop_end, "A", None, "follows from the calibrated h",
            lambda: model.span(table())[1], calibrated=True,
        ),
    ]  # fmt: skip


def _differences(run: Staircase) -> list[Check]:
    def rms(key: str) -> float:
        fitted = calibration(run.stated) if key == "calibrated" else None
        return model.rms(model.predicted(key, run.stated, fitted), run, *KEPT)

    def check(key: str, meaning: str) -> Check:
        return Check(
            f"rms-{key}", f"R(I) less measured, 1.3 to 4.5 V, rms: {key}", RUN_5, None, "ohm",
            None, f"{meaning}; the measured drop is 0.13 ohm", lambda: rms(key),
        )  # fmt: skip

    return [check(key, meaning) for key, meaning in model.VARIANTS.items()]
