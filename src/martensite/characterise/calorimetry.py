"""Transformation temperatures, latent heat and heat capacity from differential scanning calorimetry (DSC).

    A_s, A_f    onset and endset of the hottest peak on heating
    M_s, M_f    onset and endset of the coldest peak on cooling
    R_s, R_f    onset and endset of a second, hotter peak on cooling (R-phase)

Ramps of several rates are extrapolated to rate 0 along a straight line, because the sample lags behind. The heat
capacity of a phase follows from ramps of different signed rates, c_app = c + z/(dT/dt), beyond all peaks.

Source: ASTM F2004 (temperatures), ASTM F2005 (terms).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError, suggest_name
from martensite.base.files import write_file
from martensite.base.toml_text import as_toml
from martensite.characterise.estimate import MeasuredValue
from martensite.characterise.heat_peaks import BASELINES, SIGMOID, HeatPeak, RampPeaks, find_peaks, find_sign
from martensite.characterise.heat_ramps import PLAIN, HeatRamp, cut_ramps, find_heat_unit, list_rates
from martensite.characterise.regression import fit_powers
from martensite.signals.records import Record

TEMPERATURES = ("A_s", "A_f", "M_s", "M_f", "R_s", "R_f")
UNEQUAL = 0.15
"""Relative difference of the areas on heating and cooling above which a remark is made."""
PLAUSIBLE = 150.0, 1500.0
"""Range of heat capacities of these alloys, with a margin [J/kg/K]."""
UNSURE = 0.03
"""Relative difference of the areas above both baselines above which a remark is made."""


@dataclass(frozen=True)
class Calorimetry:
    """Results of DSC ramps."""

    ramps: tuple[RampPeaks, ...]
    baseline: str
    """`sigmoid` or `line`."""
    values: Mapping[str, MeasuredValue]
    """Temperatures at zero stress by name [K]."""
    latent_heat: MeasuredValue | None
    """Mean over all ramps [J/kg]; None without a calibrated heat flow."""
    heat_capacity: Mapping[str, MeasuredValue]
    """Of `A` and `M` [J/kg/K], where ramps of different rates determine it."""
    assumed_unit: str = ""
    """Assumed unit of the heat flow; empty if the file has it."""
    remarks: tuple[str, ...] = ()

    @property
    def at_zero_rate(self) -> bool:
        """Return whether temperatures are extrapolated to rate 0."""
        return any(_has_rates(self.list_ramps(heating)) for heating in (True, False))

    def list_ramps(self, heating: bool) -> list[RampPeaks]:
        """Return the ramps of one direction."""
        return [one for one in self.ramps if one.ramp.is_heating is heating]

    def to_dict(self) -> dict[str, Any]:
        """Return all values by name in SI, for JSON; without the rows."""
        ramps = [
            {
                "record": one.ramp.name,
                "ramp": one.ramp.number,
                "rate": one.ramp.rate,
                "latent_heat": one.enthalpy,
                "latent_heat_other_baseline": one.other_enthalpy,
                "peaks": [peak.to_dict() for peak in one.peaks],
            }
            for one in self.ramps
        ]
        return {
            "baseline": self.baseline,
            **{name: value.to_dict() for name, value in self.values.items()},
            "latent_heat": None if self.latent_heat is None else self.latent_heat.to_dict(),
            "heat_capacity": {name: value.to_dict() for name, value in self.heat_capacity.items()},
            "assumed_unit": self.assumed_unit,
            "ramps": ramps,
            "remarks": list(self.remarks),
        }

    def write_material(self, path: str | Path, title: str = "", cite: str = "martensite") -> None:
        """Write a material file with the measured values, replacing an existing file.

        Args:
            path: path of the file, ending in .toml. Its folder must exist.
            title: title of the material, by default from the records.
            cite: bibliography key of the records, by default the key of this package.

        Raises:
            DataError: the path does not end in .toml, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() != ".toml":
            raise DataError(f"A material file ends in .toml, but this is `{path}`.")
        names = ", ".join(dict.fromkeys(one.ramp.name for one in self.ramps))
        text = f"DSC record {names}: tangents and area above the {self.baseline} baseline"
        document = {
            "title": title or f"DSC of {names}",
            "summary": f"Transformation temperatures and latent heat by differential scanning calorimetry, of {names}.",
            "limits": " ".join(("Measured at zero stress.", *self.remarks)).replace("`", ""),
            "sources": {"dsc": {"cite": cite, "text": text}},
            "values": dict(self._list_values()),
        }
        write_file(path, as_toml(document))

    def _list_values(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield the entries of a material file."""
        for name, one in self.values.items():
            yield name, _write_entry(f"{one.value - 273.15:.5g} degC")
        if self.latent_heat is not None:
            note = f"per assumed {self.assumed_unit}" if self.assumed_unit else ""
            yield "latent_heat", _write_entry(f"{1e-3 * self.latent_heat.value:.4g} kJ/kg", note)
        if self.heat_capacity:
            note = f"mean of {' and '.join(self.heat_capacity)}"
            mean = float(np.mean([one.value for one in self.heat_capacity.values()]))
            yield "heat_capacity", _write_entry(f"{mean:.4g} J/kg/K", note)


def _write_entry(value: str, note: str = "") -> dict[str, str]:
    return {"value": value, "kind": "measured", "source": "dsc"} | ({"note": note} if note else {})


def fit_calorimetry(
    records: Record | Sequence[Record],
    *,
    mass: float | Sequence[float | None] | None = None,
    rate: float | None = None,
    baseline: str = SIGMOID,
) -> Calorimetry:
    """Return transformation temperatures and latent heat of DSC records of one sample.

    Args:
        records: records with `temperature` [K] and `heat_flow` [W/kg or W], each with one or more ramps.
        mass: mass of the sample [kg], for all records or one each; required for a heat flow in watts.
        rate: heating rate [K/s] of records without times.
        baseline: `sigmoid` or `line`.

    Raises:
        DataError: a record has no ramp or no complete peak.
        ParameterError: the baseline is unknown, or records and masses differ in number.
    """
    if baseline not in BASELINES:
        raise ParameterError(f"There is no baseline `{baseline}`. {suggest_name(baseline, BASELINES)}")
    ones = [records] if isinstance(records, Record) else list(records)
    ramps = [ramp for one, grams in _pair_masses(ones, mass) for ramp in cut_ramps(one, grams, rate)]
    sign, remarks = _find_common_sign(ramps)
    peaks, left = _find_all_peaks(ramps, sign, baseline)
    remarks += left
    assumed = "W/g" if any(find_heat_unit(one) == PLAIN for one in ones) else ""
    values = {name: one for name in TEMPERATURES if (one := _find_temperature(name, peaks)) is not None}
    capacity, heat = _find_capacities(peaks), _average_areas(peaks)
    remarks += [*_list_remarks(peaks), *_judge_capacities(capacity)]
    good = {name: one for name, one in capacity.items() if PLAUSIBLE[0] < one.value < PLAUSIBLE[1]}
    return Calorimetry(tuple(peaks), baseline, values, heat, good, assumed, tuple(remarks))


def _pair_masses(
    records: Sequence[Record], mass: float | Sequence[float | None] | None
) -> list[tuple[Record, float | None]]:
    """Return each record with its mass [kg]."""
    masses = list(mass) if isinstance(mass, Sequence) else [mass] * len(records)
    if len(masses) != len(records) or not records:
        raise ParameterError(f"There must be one mass per record, but there are {len(masses)} and {len(records)}.")
    return list(zip(records, masses, strict=True))


def _find_all_peaks(ramps: Sequence[HeatRamp], sign: float, baseline: str) -> tuple[list[RampPeaks], list[str]]:
    """Return the peaks of all ramps, and the reasons for ramps without peaks.

    Raises:
        DataError: no ramp has a complete peak.
    """
    peaks, left = list[RampPeaks](), list[str]()
    for ramp in ramps:
        try:
            peaks.append(find_peaks(ramp, sign, baseline))
        except DataError as error:
            left.append(str(error))
    if not peaks:
        raise DataError(left[-1])
    return peaks, left


def _find_common_sign(ramps: Sequence[HeatRamp]) -> tuple[float, list[str]]:
    """Return the sign of the largest peak of all ramps, and a remark if ramps disagree."""
    signs = [find_sign(ramp) for ramp in ramps]
    best = max(range(len(ramps)), key=lambda k: float(np.ptp(ramps[k].capacity)))
    wrong = [f"{ramp.number}" for ramp, sign in zip(ramps, signs, strict=True) if sign != signs[best]]
    if not wrong:
        return signs[best], []
    listed = " and ".join(wrong)
    return signs[best], [
        f"Ramp {listed} has its largest peak against the direction of the other ramps; a cold crystallisation or a "
        "drift of the zero line looks like this."
    ]


def _pick_temperature(name: str, peaks: Sequence[HeatPeak]) -> float | None:
    """Return a temperature from the peaks of a ramp, in the order of temperature; None without its peak."""
    if name.startswith("R"):
        if len(peaks) < 2:
            return None
        return peaks[-1].high if name == "R_s" else peaks[-1].low
    one = peaks[-1] if name.startswith("A") else peaks[0]
    return one.low if name in ("A_s", "M_f") else one.high


def _find_temperature(name: str, peaks: Sequence[RampPeaks]) -> MeasuredValue | None:
    """Return a temperature as the mean over ramps, or at rate 0 from ramps of several rates."""
    own = [one for one in peaks if one.ramp.is_heating is name.startswith("A")]
    pairs = [(abs(one.ramp.rate), x) for one in own if (x := _pick_temperature(name, one.peaks)) is not None]
    if not pairs:
        return None
    if _has_rates(own) and len(pairs) == len(own):
        return fit_powers([rate for rate, _ in pairs], [x for _, x in pairs], (0, 1)).coefficient(0)
    return _average([x for _, x in pairs])


def _has_rates(peaks: Sequence[RampPeaks]) -> bool:
    """Return whether ramps of one direction have several rates."""
    return len(list(list_rates([one.ramp for one in peaks]))) > 1


def _average(values: Sequence[float]) -> MeasuredValue:
    """Return the mean with its standard error; NaN for a single value."""
    count = len(values)
    error = float(np.std(values, ddof=1)) / math.sqrt(count) if count > 1 else math.nan
    return MeasuredValue(float(np.mean(values)), error, count - 1)


def _average_areas(peaks: Sequence[RampPeaks]) -> MeasuredValue:
    """Return the mean of the areas; its error follows from the scatter of ramps of one direction."""
    ways = [[one.enthalpy for one in peaks if one.ramp.is_heating is way] for way in (True, False)]
    means = [float(np.mean(way)) for way in ways if way]
    freedom = len(peaks) - len(means)
    square = sum((x - np.mean(way)) ** 2 for way in ways for x in way)
    error = math.sqrt(float(square) / freedom / len(peaks)) if freedom else math.nan
    return MeasuredValue(float(np.mean(means)), error, freedom)


def _find_capacities(peaks: Sequence[RampPeaks]) -> dict[str, MeasuredValue]:
    """Return the heat capacities beyond the peaks, from ramps of different signed rates."""
    inverse = [1.0 / one.ramp.rate for one in peaks]
    if len(peaks) < 2 or np.ptp(inverse) < 0.2 * max(map(abs, inverse)):
        return {}
    low, high = min(one.span[0] for one in peaks), max(one.span[1] for one in peaks)
    lowest = max(float(one.ramp.temperature[0]) for one in peaks)
    highest = min(float(one.ramp.temperature[-1]) for one in peaks)
    values: dict[str, MeasuredValue] = {}
    for name, ends in (("M", (lowest, low)), ("A", (high, highest))):
        if ends[1] - ends[0] > 2.0:
            rows = [(one.ramp.temperature >= ends[0]) & (one.ramp.temperature <= ends[1]) for one in peaks]
            means = [float(np.mean(one.capacity[row])) for one, row in zip(peaks, rows, strict=True)]
            values[name] = fit_powers(inverse, means, (0, 1)).coefficient(0)
    return values


def _judge_capacities(values: Mapping[str, MeasuredValue]) -> Iterator[str]:
    wrong = [f"{one.value:.3g}" for one in values.values() if not PLAUSIBLE[0] < one.value < PLAUSIBLE[1]]
    if wrong:
        yield (
            f"The heat capacity beyond the peaks would be {' and '.join(wrong)} J/(kg K): the zero line of the heat "
            "flow was changed, so that no heat capacity is reported."
        )


def _list_remarks(peaks: Sequence[RampPeaks]) -> Iterator[str]:
    """Yield remarks on areas and numbers of peaks."""
    up, down = ([one.enthalpy for one in peaks if one.ramp.is_heating is way] for way in (True, False))
    for ones, way in ((up, "heating"), (down, "cooling")):
        if not ones:
            yield f"There is no complete ramp on {way}, so its temperatures are missing."
    if up and down and abs(np.mean(up) - np.mean(down)) > UNEQUAL * max(np.mean(up), np.mean(down)):
        yield (
            f"The area is {1e-3 * np.mean(up):.3g} J/g on heating and {1e-3 * np.mean(down):.3g} J/g on cooling: a "
            "transformation may be incomplete."
        )
    for one in peaks:
        if len(one.peaks) == 2 and not one.ramp.is_heating:
            yield f"The hotter of two peaks on {one.ramp.label} is taken for the R-phase."
        elif len(one.peaks) > 2:
            yield f"There are {len(one.peaks)} peaks on {one.ramp.label}; the outermost are used."
        if abs(one.enthalpy - one.other_enthalpy) > UNSURE * one.enthalpy:
            yield (
                f"On {one.ramp.label} the other baseline gives {1e-3 * one.other_enthalpy:.3g} J/g in place of "
                f"{1e-3 * one.enthalpy:.3g} J/g."
            )
