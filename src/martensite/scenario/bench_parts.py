"""Sensors, observers, supervisor and faults of a scenario, from their tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from martensite.base.parameters import Parametrised
from martensite.scenario.assemble import Assembly, section_of
from martensite.scenario.bench_guard import note_origins, with_plant
from martensite.scenario.bench_tables import (
    FAULTS,
    MODEL,
    NAME,
    SECTIONS,
    SUPERVISOR,
    Row,
    check_name,
    flatten_table,
    kind_of,
    list_texts,
)
from martensite.scenario.build import Builder, Table, name_section
from martensite.scenario.overrides import change_document
from martensite.scenario.places import Places
from martensite.scenario.scales import Scales

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem
    from martensite.control.faults.base import AbstractFault
    from martensite.control.loop.bench import Bench
    from martensite.control.loop.mounted import Mounted
    from martensite.control.loop.supervisor import AbstractSupervisor
    from martensite.control.observers.base import AbstractObserver
    from martensite.control.sensors.base import AbstractSensor


GUARD = "guard"
"""Kind of supervisor whose checks may come from the plant."""
MEASURED = "reading"
"""What a sensor calls its own reading."""


@dataclass(frozen=True)
class PartsBuilder:
    """Builds what is around a plant; notes origins and places of all numbers."""

    assembly: Assembly
    plant: AbstractSystem
    """What everything is around."""
    places: Places

    def builder(self, scales: Scales, extra: tuple[str, ...] = (), **made: Any) -> Builder:
        """A builder of components with levels in some units; see `Builder` for the rest."""
        origins = self.assembly.origins
        return Builder(scales=scales, origins=origins, extra=extra, plain=True, made=made)

    def model(self, cls: type[Parametrised], table: Table, path: str, where: str) -> Table:
        """The model of a component that has one, as what is made elsewhere."""
        declared = cls.declarations.get(MODEL)
        if declared is None or declared.kind != "part" or declared.registry is not None:
            return {}
        self.places.note_system(f"{where}.{MODEL}", f"{path}.{MODEL}")
        changes = dict(flatten_table(table.get(MODEL, {}), ""))
        if not changes:
            return {MODEL: self.plant}
        origins = self.assembly.origins
        origins.update(dict.fromkeys((f"{path}.{MODEL}.{key}" for key in changes), "scenario"))
        with name_section(f"{path}.{MODEL}"):
            document = self.assembly.document
            plain = {name: own for name, own in document.items() if name not in SECTIONS}
            own = change_document(plain, changes)
            model = replace(self.assembly, document=own, origins={}, waveforms={}, follows={})
            return {MODEL: model.system()}

    def sensor(self, row: Row) -> tuple[str, Mounted]:
        """A sensor in its place, and its name: by default that of what it measures."""
        from martensite.control.loop.mounted import Mounted
        from martensite.control.sensors.base import SENSORS

        name, table, path = row
        mount = tuple(n for n in Mounted.declarations if n != "sensor")
        names = (NAME,) if path == "sensor" else ()
        cls = cast("type[AbstractSensor]", kind_of(SENSORS, table, path))
        given = {key: value for key, value in table.items() if key in mount}
        seen = list_texts(given.get("of")) or list(cls.sees)
        unit = cls.unit or self._output_unit(seen)
        scales = Scales(readings={MEASURED: unit}, named=(MEASURED,))
        sensor = self.builder(scales, (*mount, *names)).build(cls, table, path)
        mounted = self.builder(scales, sensor=sensor).build(Mounted, given, path)
        same = seen and unit == self._output_unit(seen)
        natural = seen[0].replace(".", "_") if same else str(table["kind"]).replace("-", "_")
        name = name or str(table.get(NAME, natural))
        check_name(name, path)
        self.places.note(f"sensors.{name}", path)
        self.places.note(f"sensors.{name}.sensor", path, scales)
        return name, mounted

    def _output_unit(self, seen: list[str]) -> str:
        """Unit of the first output that a sensor looks at; the bench checks the name."""
        known = self.plant.outputs()
        return known[seen[0]].unit if seen and seen[0] in known else "1"

    def observer(self, bench: Bench, row: Row) -> tuple[str, AbstractObserver]:
        """An observer of a bench with sensors, and its name: by default its kind."""
        from martensite.control.observers.base import OBSERVERS

        name, table, path = row
        cls = kind_of(OBSERVERS, table, path)
        name = name or str(table["kind"]).replace("-", "_")
        check_name(name, path)
        where = f"observers.{name}"
        scales = Scales(readings=reading_units(bench))
        self.places.note(where, path, scales)
        made = self.model(cls, table, path, where)
        extra = (MODEL,) if made else ()
        found = self.builder(scales, extra, **made).build(cls, table, path)
        self.places.note_scales(where, found, scales)
        return name, found

    def supervisor(self, bench: Bench) -> AbstractSupervisor | None:
        """Who has the last word on a bench, if anybody."""
        if SUPERVISOR not in self.assembly.document:
            return None
        from martensite.control.loop.supervisor import SUPERVISORS

        units = {drive.unit for drive in self.plant.drives()}
        unit = units.pop() if len(units) == 1 else "1"
        scales = Scales(unit, reading_units(bench))
        document = self.assembly.document
        table = section_of(document, SUPERVISOR)
        cls, builder, full = kind_of(SUPERVISORS, table, SUPERVISOR), self.builder(scales), table
        if cls.registered_name == GUARD:
            full = with_plant(table, bench, builder, document)
        found = builder.build(cls, full, SUPERVISOR)
        note_origins(table, full, self.assembly.origins)
        self.places.note(SUPERVISOR, SUPERVISOR, scales)
        self.places.note_scales(SUPERVISOR, found, scales)
        return found

    def fault(self, bench: Bench, row: Row) -> tuple[str, AbstractFault]:
        """What goes wrong on a bench, and its name; levels are in the unit of what it disturbs."""
        from martensite.control.faults.base import FAULTS as KNOWN

        name, table, path = row
        check_name(name, path)
        drives = {drive.name: drive.unit for drive in self.plant.drives()}
        only = next(iter(drives.values())) if len(drives) == 1 else "1"
        scales = Scales(drives.get(str(table.get("drive"))) or only, reading_units(bench))
        found = self.builder(scales).choose(KNOWN, table, path)
        self.places.note(f"{FAULTS}.{name}", path, scales)
        self.places.note_scales(f"{FAULTS}.{name}", found, scales)
        return name, found


def reading_units(bench: Bench) -> dict[str, str]:
    """SI units of everything that may be read on a bench."""
    from martensite.control.loop.names import list_readings

    return {name: output.unit for name, output in list_readings(bench).items()}
