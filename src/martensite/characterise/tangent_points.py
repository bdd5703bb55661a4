"""Transformation temperatures of one isobaric heating-cooling cycle by the tangent method.

Each branch has three lines, two of a single phase and one of the transformation
(`martensite.characterise.tangent_lines`). Their intersections are

    on heating   A_s (cold line), A_f (hot line)
    on cooling   M_s (hot line), M_f (cold line)

at the stress of the cycle. The transformation strain H is the vertical distance of the outer lines at the half-way
temperature, as the mean of both branches. The slopes of the outer lines are apparent thermal expansions. They include
temperature-dependent moduli, compliance of the test machine, and trailing transformation.

Source: ASTM E3097 (constant force, thermal cycling), and ASTM F2082 for the construction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from martensite.base.errors import DataError
from martensite.characterise.isobaric_cycles import CycleBranch, IsobaricCycle, cut_cycle
from martensite.characterise.tangent_lines import BranchTangents, branch_tangents
from martensite.signals.records import Record

FEW_ROWS = 6
"""Number of rows between start and finish below which a remark is made."""
SHORT = 0.5
"""Range beyond a transformation, as a fraction of its width, below which a remark is made."""


@dataclass(frozen=True)
class TangentPoints:
    """Results of the tangents of one cycle."""

    name: str
    """Name of the record."""
    stress: float
    """[Pa]"""
    stress_deviation: float
    """Standard deviation of the stress over the cycle [Pa]."""
    heating: BranchTangents
    cooling: BranchTangents
    residual_strain: float
    """Final minus initial strain of the cycle, by the outer lines at the farthest common temperature [-]."""
    stroke: float
    """Largest minus smallest strain of the cycle, with noise and expansion [-]."""
    cycle: IsobaricCycle
    """Rows of the cycle."""
    remarks: tuple[str, ...] = ()
    """Remarks for the user, in sentences."""

    @property
    def A_s(self) -> float:
        """Return the austenite start temperature at this stress [K]."""
        return self.heating.low

    @property
    def A_f(self) -> float:
        """Return the austenite finish temperature at this stress [K]."""
        return self.heating.high

    @property
    def M_s(self) -> float:
        """Return the martensite start temperature at this stress [K]."""
        return self.cooling.high

    @property
    def M_f(self) -> float:
        """Return the martensite finish temperature at this stress [K]."""
        return self.cooling.low

    @property
    def A_half(self) -> float:
        """Return the temperature half-way to austenite [K]."""
        return self.heating.half

    @property
    def M_half(self) -> float:
        """Return the temperature half-way to martensite [K]."""
        return self.cooling.half

    @property
    def hysteresis(self) -> float:
        """Return A_half - M_half [K]."""
        return self.A_half - self.M_half

    @property
    def H(self) -> float:
        """Return the transformation strain at this stress, mean of heating and cooling [-]."""
        up, down = self.heating.transformation_strain, self.cooling.transformation_strain
        return 0.5 * (up + down)

    @property
    def alpha_A(self) -> float:
        """Return the apparent thermal expansion of austenite, mean of both branches [1/K]."""
        return 0.5 * (self.heating.hot.slope + self.cooling.hot.slope)

    @property
    def alpha_M(self) -> float:
        """Return the apparent thermal expansion of martensite, mean of both branches [1/K]."""
        return 0.5 * (self.heating.cold.slope + self.cooling.cold.slope)

    def to_dict(self) -> dict[str, Any]:
        """Return all values by name in SI, for JSON; without the rows."""
        names = (
            "name",
            "stress",
            "stress_deviation",
            "A_s",
            "A_f",
            "M_s",
            "M_f",
            "A_half",
            "M_half",
            "hysteresis",
            "H",
            "residual_strain",
            "stroke",
            "alpha_A",
            "alpha_M",
        )
        return {name: getattr(self, name) for name in names} | {
            "heating": self.heating.to_dict(),
            "cooling": self.cooling.to_dict(),
            "remarks": list(self.remarks),
        }


def find_tangent_points(record: Record, *, stress: float | None = None, cycle: int = -1) -> TangentPoints:
    """Read one isobaric cycle by the tangent method.

    Args:
        record: columns `temperature` [K], `strain` [-] (elongation positive) and optionally `stress` [Pa].
        stress: constant stress [Pa], by default the mean of the column over the cycle.
        cycle: index of the cycle, by default the last.

    Raises:
        DataError: the columns contradict their names, or a full cycle or a full transformation is missing.
        ParameterError: the cycle does not exist.
    """
    cut = cut_cycle(record, stress=stress, cycle=cycle)
    heating, cooling = _read_branch(cut, "heating"), _read_branch(cut, "cooling")
    if heating.half < cooling.half:
        cut = _reverse_cycle(cut)
        heating, cooling = cooling, heating
    strains = cut.heating.strain + cut.cooling.strain
    return TangentPoints(
        cut.name,
        cut.stress,
        cut.stress_deviation,
        heating,
        cooling,
        residual_strain=_residual_strain(heating, cooling, cut.cold_start),
        stroke=max(strains) - min(strains),
        cycle=cut,
        remarks=(
            *cut.remarks,
            *_list_remarks(cut.heating, heating, "heating"),
            *_list_remarks(cut.cooling, cooling, "cooling"),
        ),
    )


def _read_branch(cut: IsobaricCycle, way: str) -> BranchTangents:
    rows = getattr(cut, way)
    tangents = branch_tangents(rows.temperature, rows.strain, f"`{cut.name}` on {way}")
    strain = tangents.transformation_strain
    if strain < 0.0:
        raise DataError(
            f"The strain of `{cut.name}` is larger in austenite than in martensite, by "
            f"{-strain:.3g}. Elongation must be positive: change the sign of the strain and, in compression, "
            "the sign of the stress."
        )
    return tangents


def _reverse_cycle(cut: IsobaricCycle) -> IsobaricCycle:
    """Return a cycle in reverse order of rows, with heating and cooling exchanged."""
    if cut.timed:
        raise DataError(
            f"Record `{cut.name}` transforms at a lower temperature on heating than on cooling; "
            "its times decrease, or its thermometer lags by more than the hysteresis."
        )
    remark = "The rows stand in reverse order: heating and cooling are exchanged."
    return replace(cut, heating=cut.cooling, cooling=cut.heating, remarks=(*cut.remarks, remark))


def _residual_strain(heating: BranchTangents, cooling: BranchTangents, cold_start: bool) -> float:
    """Return the opening of the loop at the start and end of the cycle [-]."""
    if cold_start:
        at = max(heating.span[0], cooling.span[0])
        return float(cooling.cold.value(at) - heating.cold.value(at))
    at = min(heating.span[1], cooling.span[1])
    return float(heating.hot.value(at) - cooling.hot.value(at))


def _list_remarks(rows: CycleBranch, tangents: BranchTangents, way: str) -> list[str]:
    """Return remarks on a short range beyond a transformation, or few rows within it."""
    remarks: list[str] = []
    between = sum(tangents.low <= kelvin <= tangents.high for kelvin in rows.temperature)
    if between < FEW_ROWS:
        remarks.append(
            f"On {way} only {between} rows lie between start and finish: both are uncertain by "
            "about the distance of rows."
        )
    for side, line, room in zip(("below", "above"), ("cold", "hot"), tangents.room(), strict=True):
        if room < SHORT:
            remarks.append(
                f"On {way} the record goes only {room:.2g} widths of the transformation {side} "
                f"it: the {line} line is uncertain."
            )
    return remarks


def find_all_cycles(record: Record, *, stress: float | None = None) -> list[TangentPoints | str]:
    """Return every cycle of a record by the tangent method, or the reason for a cycle without lines.

    Args:
        record: as in `find_tangent_points`.
        stress: constant stress [Pa], by default the mean of the column over each cycle.

    Raises:
        DataError: the record has no full cycle.
    """
    cycles: list[TangentPoints | str] = []
    for number in range(cut_cycle(record, stress=stress).cycles):
        try:
            cycles.append(find_tangent_points(record, stress=stress, cycle=number))
        except DataError as error:
            cycles.append(str(error))
    return cycles
