"""A statement to be checked where the record is at hand, and reported as open where it is not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from martensite.studies.base import Claim
from martensite.studies.electrothermal.printed import SOURCE
from martensite.studies.electrothermal.record import DATA, here

PROGRAM = f"{SOURCE}, experimental/TECA, read_data.py"
RUN_5 = f"{SOURCE}, experimental/TECA, run 5"
TRAINED_RUN = f"{SOURCE}, experimental/TECA, trained wire at 172 MPa"
ABSENT = f"the data are not on this machine: `martensite data fetch {DATA}`"


@dataclass(frozen=True)
class Check:
    """A statement about the record: checked with a tolerance, else calibrated or reported."""

    id: str
    statement: str
    source: str
    published: float | None
    unit: str
    tolerance: float | None
    why: str
    value: Callable[[], float]
    """Computes the number; called only where the record is on this machine."""
    calibrated: bool = False

    def claim(self) -> Claim:
        """The claim with its number and verdict."""
        value = self.value()
        if self.calibrated:
            return Claim.calibrated(
                self.id, self.statement, self.source, self.published, value, self.unit, self.why
            )
        if self.published is None or self.tolerance is None:
            return Claim.reported(self.id, self.statement, self.source, value, self.unit, self.why)
        return Claim.checked(
            self.id, self.statement, self.source, self.published, value, self.unit,
            self.tolerance, self.why,
        )  # fmt: skip

    def absent(self) -> Claim:
        """The claim without a number."""
        return Claim(
            self.id, self.statement, self.source, self.published, None, self.unit, None,
            "not checkable", ABSENT,
        )  # fmt: skip


def settle(checks: Sequence[Check], *files: str) -> list[Claim]:
    """The claims of statements that rest on files of the data set."""
    return [check.claim() if here(*files) else check.absent() for check in checks]
