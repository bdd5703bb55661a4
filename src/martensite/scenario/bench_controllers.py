"""Controllers of a scenario and their references, from their tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Parametrised
from martensite.scenario.assemble import section_of
from martensite.scenario.bench_parts import PartsBuilder, reading_units
from martensite.scenario.bench_tables import (
    PAIRS,
    PERIOD,
    REFERENCE,
    Row,
    add_period,
    gather_numbers,
    kind_of,
)
from martensite.scenario.build import Table, name_section
from martensite.scenario.scales import Scales
from martensite.signals.constant import Constant

if TYPE_CHECKING:
    from martensite.control.controllers.base import AbstractController
    from martensite.control.loop.bench import Bench

CONTROLLER = "controller"


@dataclass(frozen=True)
class ControllersBuilder:
    """Builds controllers around a bench that has none yet."""

    parts: PartsBuilder
    bench: Bench

    def controller(self, row: Row) -> tuple[str, AbstractController]:
        """A controller with its reference, and the drive that it has."""
        from martensite.control.controllers.base import CONTROLLERS

        name, table, path = row
        name, unit = self._drive(name, path)
        given, below = self._reference(name, table, path)
        cls = kind_of(CONTROLLERS, table, path)
        built = self._bare(cls, (name, table, path), unit)
        kind = self._followed(built, path, unit)
        self.parts.places.note(f"controllers.{name}.{REFERENCE}", below, Scales(kind))
        waveform = self.parts.assembly.waveform_of(given, kind, below, name)
        return name, built.with_parts(reference=waveform)

    def _bare(self, cls: type[Parametrised], row: Row, unit: str) -> AbstractController:
        """A controller with nothing to follow yet."""
        name, table, path = row
        where, parts = f"controllers.{name}", self.parts
        scales = Scales(unit, reading_units(self.bench))
        parts.places.note(where, path, scales)
        made = {REFERENCE: Constant(level=0.0), **parts.model(cls, table, path, where)}
        full, moved = gather_numbers(cls, add_period(cls, table, self.bench.period))
        extra = (*made, PERIOD) if path == CONTROLLER else tuple(made)
        built = parts.builder(scales, extra, **made).build(cls, full, path)
        parts.places.note_scales(where, built, scales)
        for inner, flat in moved.items():
            parts.places.note(f"{where}.{inner}", f"{path}.{flat}")
            parts.assembly.origins[f"{path}.{flat}"] = "scenario"
        return built

    def _followed(self, built: AbstractController, path: str, unit: str) -> str:
        """Unit of the reference of a controller.

        Raises:
            ParameterError: it reads what is not known.
        """
        from martensite.control.controllers.base import require_readings

        known = reading_units(self.bench)
        with name_section(path):
            require_readings(built, known)
            return built.reference_unit(known, unit)

    def _drive(self, name: str, path: str) -> tuple[str, str]:
        """Name and unit of the drive that a controller has; a single one has the only free one."""
        drives = {drive.name: drive.unit for drive in self.bench.plant.drives()}
        waved = self.parts.assembly.waveforms
        free = [one for one in drives if one not in waved]
        if not name and len(drives) > 1 and len(free) != 1:
            raise ParameterError(
                f"[{path}] It is not clear which of the drives {', '.join(drives)} it has; write "
                f"[{PAIRS[CONTROLLER]}.{(free or list(drives))[0]}]."
            )
        name = name or (list(drives) if len(drives) == 1 else free)[0]
        if name not in drives:
            raise ParameterError(
                f"[{path}] There is no drive `{name}`. {suggest_name(name, drives)}"
            )
        if name in waved:
            raise ParameterError(
                f"[{path}] has the drive `{name}`, which has a waveform as well; leave one out."
            )
        return name, drives[name]

    def _reference(self, name: str, table: Table, path: str) -> tuple[Any, str]:
        """What a controller shall follow, and where that stands."""
        single, document = path == CONTROLLER, self.parts.assembly.document
        outer = REFERENCE if single else PAIRS[REFERENCE]
        given = section_of(document, outer, {})
        there = bool(given) if single else name in given
        title = outer if single else f"{outer}.{name}"
        if there and REFERENCE in table:
            raise ParameterError(f"A scenario has [{title}] or [{path}.{REFERENCE}], not both.")
        if REFERENCE in table:
            return table[REFERENCE], f"{path}.{REFERENCE}"
        if not there:
            raise ParameterError(
                f"[{path}] needs a reference; write a section [{title}] with a waveform, such as "
                f'`kind = "constant"` and `level = …`, in a unit of what is measured.'
            )
        return (given if single else given[name]), title
