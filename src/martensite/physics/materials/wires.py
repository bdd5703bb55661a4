"""Wire catalogues: makers' tables of sizes, one TOML file per product.

Every cell has a value with a unit, a kind (as in `martensite.physics.materials.base`) and a source. `datasheet` cells
are printed in a named text; the originals of `recalled` cells were not seen. Pull and deformation are printed as
masses; `pull_force` and `deformation_force` are their weights in newton.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from martensite.base.errors import UnknownNameError
from martensite.physics.materials.base import (
    MaterialNumber,
    Source,
    read_number,
    read_sources,
    read_table,
    read_text,
    read_toml,
    refuse_unknown,
)

GRAVITY = 9.80665
"""Standard gravity [m/s²]."""
UNITS = {
    "diameter": "m",
    "resistance": "ohm/m",
    "pull": "kg",
    "deformation": "kg",
    "current": "A",
    "cooling_70": "s",
    "cooling_90": "s",
}
"""Column of a catalogue -> SI unit of its cells."""
Cell = MaterialNumber
"""Cell of a catalogue: value in SI, text as written, unit, kind, source, note."""
_DATA = Path(__file__).parent / "catalogues"


@dataclass(frozen=True)
class WireSize:
    """One row of a catalogue."""

    name: str
    """Trade name of the size, such as `0.15 mm`."""
    diameter: Cell
    """[m]"""
    resistance: Cell
    """Per metre of wire [ohm/m]."""
    pull: Cell
    """Mass that the wire lifts at the maker's working stress [kg]."""
    deformation: Cell
    """Mass that stretches the cold wire [kg]."""
    current: Cell
    """Current that contracts the wire in 1 s [A]."""
    cooling_70: Cell
    """Cooling time of the 70 °C alloy [s]."""
    cooling_90: Cell
    """Cooling time of the 90 °C alloy [s]."""

    @property
    def section(self) -> float:
        """Return the cross-section [m²]."""
        return 0.25 * math.pi * self.diameter.value**2

    @property
    def pull_force(self) -> float:
        """Return the force of the hot wire at the maker's working stress [N]."""
        return GRAVITY * self.pull.value

    @property
    def deformation_force(self) -> float:
        """Return the force that stretches the cold wire [N]."""
        return GRAVITY * self.deformation.value

    def cells(self) -> dict[str, Cell]:
        """Return the cells by column."""
        return {name: getattr(self, name) for name in UNITS}


@dataclass(frozen=True)
class WireCatalogue:
    """A maker's table of wire sizes, from one file."""

    name: str
    title: str
    summary: str
    limits: str
    """Conditions of validity, and unverified values."""
    sources: dict[str, Source]
    sizes: dict[str, WireSize]
    """By name, from thin to thick."""

    def __getitem__(self, name: str) -> WireSize:
        """Return a size by its name.

        Raises:
            UnknownNameError: the catalogue has no such size.
        """
        if name not in self.sizes:
            raise UnknownNameError("wire size", name, self.sizes)
        return self.sizes[name]

    def interpolate(self, diameter: float) -> WireSize:
        """Return a size that is not in the table, interpolated in logarithms between its neighbours.

        Beyond the table, the last two sizes are extrapolated. The cells have the kind `assumed`.
        """
        sizes = list(self.sizes.values())
        place = sum(one.diameter.value < diameter for one in sizes)
        above = min(max(place, 1), len(sizes) - 1)
        one, other = sizes[above - 1], sizes[above]
        share = math.log(diameter / one.diameter.value) / math.log(other.diameter.value / one.diameter.value)
        note = f"not in the table: on the line, in logarithms, through {one.name} and {other.name}"
        values = {name: cell.value ** (1.0 - share) for name, cell in one.cells().items()}
        values = {name: value * other.cells()[name].value ** share for name, value in values.items()}
        cells = {
            name: MaterialNumber(value, f"{value:.4g} {UNITS[name]}", UNITS[name], "assumed", cell.source, note=note)
            for (name, value), cell in zip(values.items(), one.cells().values(), strict=True)
        }
        return WireSize(f"{1e3 * diameter:.4g} mm", **cells)


def wire_catalogues() -> list[str]:
    """Return the names of the packaged wire catalogues."""
    return sorted(path.stem for path in _DATA.glob("*.toml"))


def load_wires(name: str | Path = "flexinol") -> WireCatalogue:
    """Return a wire catalogue by its name, or from a user's file.

    Args:
        name: a name from `wire_catalogues()`, or the path of a TOML file.

    Raises:
        InputError: the catalogue does not exist, or its file is malformed.
    """
    if isinstance(name, Path) or name.endswith(".toml"):
        path = Path(name)
    else:
        path = _DATA / f"{name}.toml"
        if not path.is_file():
            raise UnknownNameError("wire catalogue", name, wire_catalogues())
    return _read_catalogue(path.stem, read_toml(path, "catalogue"), f"Catalogue file `{path.name}`")


def _read_catalogue(name: str, document: Mapping[str, Any], file: str) -> WireCatalogue:
    valid = tuple(field.name for field in fields(WireCatalogue))[1:]
    refuse_unknown(valid, document, file)
    title, summary, limits = (read_text(document, key, file) for key in valid[:3])
    sources = read_sources(document, file)
    rows = read_table(document.get("sizes", {}), f"{file}, [sizes]")
    sizes = [_read_size(key, row, sources, f"{file}, `{key}`") for key, row in rows.items()]
    sizes.sort(key=lambda size: size.diameter.value)
    return WireCatalogue(name, title, summary, limits, sources, {size.name: size for size in sizes})


def _read_size(name: str, row: Any, sources: Mapping[str, Source], where: str) -> WireSize:
    table = read_table(row, where)
    refuse_unknown(tuple(UNITS), table, where)
    return WireSize(name, **{key: _read_cell(table, key, sources, where) for key in UNITS})


def _read_cell(table: Mapping[str, Any], column: str, sources: Mapping[str, Source], where: str) -> Cell:
    place = f"{where}, `{column}`"
    return read_number(read_table(table.get(column, {}), place), UNITS[column], sources, place)
