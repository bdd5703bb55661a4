"""Materials: one TOML file per source, read on demand.

Each value has a unit, a source, a place in the source, and a kind that states its reliability:

    datasheet   printed by the maker
    measured    read directly from a measurement
    fitted      obtained by fitting a model to measurements
    assumed     chosen, for a stated reason
    recalled    known from the literature; the original was not seen

Fitted values hold for the law they were fitted with. [law] names this law and its options, the default law of a
scenario with this material; [fit] describes the fitted records.
"""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import InputError, ParameterError, UnitError, require_known, suggest_name
from martensite.base.files import read_text_file, toml_document

KINDS = ("datasheet", "measured", "fitted", "assumed", "recalled")
DOUBTFUL = ("assumed", "recalled")
"""Kinds without a measurement of this material."""
_DATA = Path(__file__).parent / "data"
_KEYS = ("title", "summary", "limits", "sources", "values", "law", "fit")
_FIELDS = ("value", "kind", "source", "where", "note")


@dataclass(frozen=True)
class Source:
    """Source of values."""

    cite: str
    """Key in the bibliography."""
    text: str


@dataclass(frozen=True)
class MaterialNumber:
    """One value of a material."""

    value: float
    """Value in the SI `unit`."""
    text: str
    """Text in the file, with its unit."""
    unit: str
    kind: str
    source: str
    """Key of a source of the material."""
    where: str = ""
    note: str = ""


@dataclass(frozen=True)
class Material:
    """Values of one material, from one file."""

    name: str
    title: str
    summary: str
    limits: str
    """Limits of validity of the parameters."""
    sources: dict[str, Source]
    values: dict[str, MaterialNumber]
    law: dict[str, Any] | None = None
    """Law for which the values hold, as in a scenario: `kind` and options; None for any law."""
    fit: dict[str, Any] | None = None
    """Basis of fitted values: records with hashes, bounds, errors; None without a fit."""

    def __repr__(self) -> str:
        kind = "" if self.law is None else f", law {self.law.get('kind', 'none')}"
        return f"Material({self.name!r}{kind}, {len(self.values)} parameters)"

    def cites(self) -> list[str]:
        """Return the bibliography keys of all used sources, in file order."""
        used = {number.source for number in self.values.values()}
        return list(dict.fromkeys(s.cite for key, s in self.sources.items() if key in used))


def material_names() -> list[str]:
    """Return the names of the packaged materials."""
    return sorted(path.stem for path in _DATA.glob("*.toml"))


def load_material(name: str | Path, folder: Path | None = None) -> Material:
    """Return a material by its name, or from a user's file.

    Args:
        name: a name from `material_names()`, or the path of a TOML file.
        folder: base of a relative path; by default the current folder.

    Raises:
        InputError: the material does not exist, or its file is malformed.
    """
    if not isinstance(cast("Any", name), str | Path):
        raise InputError(f"A material must be a name or the path of a file, but is {name!r}.")
    if isinstance(name, Path) or name.endswith(".toml") or "/" in name:
        return _read_file((folder or Path()) / name)
    require_known("material", name, material_names())
    own = _read_packaged(name)
    law, fit = deepcopy((own.law, own.fit))
    return replace(own, sources=dict(own.sources), values=dict(own.values), law=law, fit=fit)


@cache
def _read_packaged(name: str) -> Material:
    return _read_file(_DATA / f"{name}.toml")


def _read_file(path: Path) -> Material:
    return _read_material(path.stem, read_toml(path, "material"), f"Material file `{path.name}`")


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the document in a TOML file; `what` names the kind of file in errors."""
    return toml_document(read_text_file(path, what), f"{what.capitalize()} file `{path}`")


def _read_material(name: str, document: Mapping[str, Any], file: str) -> Material:
    refuse_unknown(_KEYS, document, file)
    sources = read_sources(document, file)
    values = {
        key: _read_number(key, read_table(entry, f"{file}, `{key}`"), sources, file)
        for key, entry in read_table(document.get("values", {}), f"{file}, [values]").items()
    }
    title, summary, limits = (str(document.get(key, "")) for key in _KEYS[:3])
    law, fit = (_read_optional(document, key, file) for key in ("law", "fit"))
    if law is not None:
        read_text(law, "kind", f"{file}, [law]")
    return Material(name, title or name, summary, limits, sources, values, law, fit)


def _read_optional(document: Mapping[str, Any], key: str, file: str) -> dict[str, Any] | None:
    return read_table(document[key], f"{file}, [{key}]") if key in document else None


def read_sources(document: Mapping[str, Any], file: str) -> dict[str, Source]:
    """Return the sources of a file, by key."""
    sources: dict[str, Source] = {}
    for key, entry in read_table(document.get("sources", {}), f"{file}, [sources]").items():
        where = f"{file}, source `{key}`"
        table = read_table(entry, where)
        refuse_unknown(("cite", "text"), table, where)
        sources[key] = Source(read_text(table, "cite", where), read_text(table, "text", where))
    return sources


def _read_number(name: str, entry: Mapping[str, Any], sources: dict[str, Source], file: str) -> MaterialNumber:
    if name not in NAMES:
        raise ParameterError(f"{file}: no canonical number `{name}`. {suggest_name(name, NAMES)}")
    return read_number(entry, NAMES[name][0], sources, f"{file}, `{name}`")


def read_number(entry: Mapping[str, Any], unit: str, sources: Mapping[str, Source], where: str) -> MaterialNumber:
    """Return a value declared in the SI `unit` from its table of value, kind, source, where and note.

    Raises:
        InputError: an entry is missing, unknown, or has another dimension.
    """
    refuse_unknown(_FIELDS, entry, where)
    text, kind, source = (read_text(entry, key, where) for key in _FIELDS[:3])
    if kind not in KINDS:
        raise ParameterError(f"{where}: no kind `{kind}`. {suggest_name(kind, KINDS)}")
    if source not in sources:
        raise ParameterError(f"{where}: no source `{source}`. {suggest_name(source, sources)}")
    try:
        value = units.parse_quantity(text, unit)
    except UnitError as error:
        raise UnitError(f"{where}: {error}") from None
    more = (str(entry.get(key, "")) for key in _FIELDS[3:])
    return MaterialNumber(value, text, unit, kind, source, *more)


def read_table(entry: Any, where: str) -> dict[str, Any]:
    """Return an entry that must be a table."""
    if not isinstance(entry, dict):
        raise ParameterError(f"{where} must be a table, but is {entry!r}.")
    return cast("dict[str, Any]", entry)


def read_text(entry: Mapping[str, Any], key: str, where: str) -> str:
    """Return a required text entry."""
    if key not in entry:
        raise ParameterError(f"{where} needs `{key}`; none given.")
    if not isinstance(entry[key], str):
        raise ParameterError(f"{where}: `{key}` must be text in quotes, but is {entry[key]!r}.")
    return entry[key]


def refuse_unknown(valid: tuple[str, ...], entry: Mapping[str, Any], where: str) -> None:
    """Raise `ParameterError` with the nearest valid key for an unknown key."""
    unknown = next((key for key in entry if key not in valid), None)
    if unknown is not None:
        raise ParameterError(f"{where} has no `{unknown}`. {suggest_name(unknown, valid)}")


# name -> (SI unit, meaning)
NAMES: dict[str, tuple[str, str]] = {
    "density": ("kg/m^3", "density"),
    "heat_capacity": ("J/kg/K", "specific heat capacity"),
    "latent_heat": ("J/kg", "latent heat of the whole transformation"),
    "thermal_conductivity": ("W/m/K", "thermal conductivity"),
    "E_A": ("Pa", "Young's modulus of austenite"),
    "E_M": ("Pa", "Young's modulus of martensite"),
    "Theta": ("Pa/K", "thermoelastic modulus; -E times the expansion"),
    "T_ref": ("K", "temperature of zero thermal strain"),
    "eps_L": ("1", "maximum recoverable strain"),
    "A_s": ("K", "austenite start temperature at zero stress"),
    "A_f": ("K", "austenite finish temperature at zero stress"),
    "M_s": ("K", "martensite start temperature at zero stress"),
    "M_f": ("K", "martensite finish temperature at zero stress"),
    "C_A": ("Pa/K", "Clausius–Clapeyron slope of the reverse transformation"),
    "C_M": ("Pa/K", "Clausius–Clapeyron slope of the forward transformation"),
    "R_s": ("K", "R-phase start temperature on cooling at zero stress"),
    "R_f": ("K", "R-phase finish temperature on cooling at zero stress"),
    "dT_R": ("K", "hysteresis of the R-phase"),
    "C_R": ("Pa/K", "Clausius–Clapeyron slope of the R-phase"),
    "eps_R": ("1", "transformation strain of the R-phase"),
    "E_R": ("Pa", "Young's modulus of the R-phase"),
    "latent_R": ("1", "latent heat of the R-phase as a share of that of martensite"),
    "sigma_s": ("Pa", "start stress of detwinning below M_s"),
    "sigma_f": ("Pa", "finish stress of detwinning below M_s"),
    "eps_L_compression": ("1", "maximum recoverable strain in compression"),
    "C_A_compression": ("Pa/K", "Clausius–Clapeyron slope of the reverse transformation in compression"),
    "C_M_compression": ("Pa/K", "Clausius–Clapeyron slope of the forward transformation in compression"),
    "sigma_s_compression": ("Pa", "start stress of detwinning in compression"),
    "sigma_f_compression": ("Pa", "finish stress of detwinning in compression"),
    "H_sat_compression": ("1", "transformation strain of martensite formed at high compression"),
    "H_min": ("1", "transformation strain of martensite formed at no stress"),
    "H_sat": ("1", "transformation strain of martensite formed at high stress"),
    "H_k": ("1/Pa", "rate at which the transformation strain saturates with stress"),
    "sigma_crit": ("Pa", "stress at which the transformation strain begins to grow"),
    "sigma_cal": ("Pa", "stress at which both slopes of a Lagoudas set hold"),
    "n_1": ("1", "smooth hardening: roundness of the forward start"),
    "n_2": ("1", "smooth hardening: roundness of the forward end"),
    "n_3": ("1", "smooth hardening: roundness of the reverse end"),
    "n_4": ("1", "smooth hardening: roundness of the reverse start"),
    "waist_f": ("1", "waisted hardening: waist of the forward range"),
    "waist_r": ("1", "waisted hardening: waist of the reverse range"),
    "curvature_f": ("K/Pa^2", "curved surfaces: bend of the forward line"),
    "curvature_r": ("K/Pa^2", "curved surfaces: bend of the reverse line"),
    "widening_f": ("K/Pa", "curved surfaces: growth of the forward range with stress"),
    "widening_r": ("K/Pa", "curved surfaces: growth of the reverse range with stress"),
    "rho_A": ("ohm*m", "resistivity of austenite"),
    "rho_M": ("ohm*m", "resistivity of martensite"),
    "rho_R": ("ohm*m", "resistivity of the R-phase"),
    "a_rho_R": ("1/K", "temperature coefficient of the resistivity of the R-phase"),
    "a_rho_A": ("1/K", "temperature coefficient of the resistivity of austenite"),
    "a_rho_M": ("1/K", "temperature coefficient of the resistivity of martensite"),
    "T_rho": ("K", "temperature at which both resistivities hold"),
    "nu": ("1", "Poisson's ratio"),
    "alpha_A": ("1/K", "thermal expansion of austenite"),
    "alpha_M": ("1/K", "thermal expansion of martensite"),
    "temperature_limit": ("K", "highest temperature without damage"),
    "stress_limit": ("Pa", "highest stress for long life"),
    "strain_limit": ("1", "largest strain amplitude for long life"),
    "eps_T": ("1", "transformation strain of one martensite variant"),
    "sigma_L": ("Pa", "stress of the austenite to martensite transition at T_L"),
    "T_L": ("K", "temperature at which sigma_L holds"),
    "dsigma_dT": ("Pa/K", "slope of the transition stresses with temperature"),
    "Delta_sigma": ("Pa", "width of the stress hysteresis"),
    "layer_volume": ("m^3", "volume of a transforming layer"),
    "layer_time": ("s", "time constant of a transforming layer"),
}
