"""The systems of scenarios and the waveforms that drive them.

[element], [environment] and [drive] describe the only actuator of a mechanism with one port, or the common actuator of
all ports. [actuators.PORT] holds the tables `element`, `environment` and `drive` with the differences at a port. A port
without a waveform is not driven. [driver] is another word for [drive], and [supply] a supply shared by all actuators.
[signals.NAME] is the waveform of a signal that belongs to the mechanism, such as a motor voltage, or to the cooling,
such as a fan. [model] names the file of a model instead; its inputs are such signals.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from martensite.actuators.assembly import AbstractSystem, Actuator, Group, Machine, System
from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.mechanisms.base import MECHANISMS, AbstractMechanism
from martensite.base.errors import ParameterError, suggest_name
from martensite.physics.electrical.base import SOURCES
from martensite.physics.electrical.shared_supply import SharedSupply
from martensite.physics.materials.base import Material, load_material
from martensite.physics.thermal.base import Environment
from martensite.scenario import recorded_waveforms
from martensite.scenario.build import Builder, Table, as_table, name_section, refuse_unknown
from martensite.scenario.laws import law_caution, override_caution, rphase_caution
from martensite.scenario.place_units import PlaceUnits
from martensite.scenario.plateau_section import build_with_plateaus
from martensite.signals.base import WAVEFORMS, AbstractWaveform
from martensite.simulate.drive_waveforms import Waveforms
from martensite.simulate.grid import require_unit

if TYPE_CHECKING:
    from martensite.signals.records import Record

COMMON = ("element", "environment")
DRIVE, DRIVER = "drive", "driver"
GROUP = "actuators"
SIGNALS = "signals"
SUPPLY = "supply"
MODEL = "model"


@dataclass
class Assembly:
    """System under construction."""

    document: Table
    folder: Path
    """Folder of the named files."""
    log: Record | None = None
    """Log that waveforms of kind `log` follow."""
    lead: float = 0.0
    """Time before the log [s]."""
    origins: dict[str, str] = field(default_factory=dict[str, str])
    """Origin of each number, by its dotted path."""
    waveforms: dict[str, AbstractWaveform] = field(default_factory=dict[str, AbstractWaveform])
    end: float = math.inf
    """End of the last recorded waveform [s]."""
    material: Material | None = None
    """Material of the first element that names one."""
    follows: dict[str, str] = field(default_factory=dict[str, str])
    """Followed column of the log, by drive."""
    cautions: list[str] = field(default_factory=list[str])
    """Sentences on materials whose numbers are used in another law."""
    controlled: bool = False
    """True if drives of controllers, which need no waveform, are possible."""

    @property
    def drive(self) -> str:
        """Return the name of the section of the source."""
        return drive_section(self.document)

    def system(self) -> AbstractSystem:
        """Return the system, and fill the other fields."""
        if MODEL in self.document:
            return self._build_model(section_of(self.document, MODEL))
        table = section_of(self.document, "mechanism")
        mechanism = Builder(origins=self.origins).choose(MECHANISMS, table, "mechanism")
        ports = mechanism.ports()
        system = self._build_single(mechanism) if len(ports) == 1 else self._build_machine(mechanism, ports)
        self._read_signals(system)
        return system

    def list_waveforms(self, system: AbstractSystem) -> Waveforms:
        """Return the waveform of a system with one drive, or the waveforms of several drives by name."""
        single = len(system.drives()) == len(self.waveforms) == 1
        return next(iter(self.waveforms.values())) if single else self.waveforms

    def _build_model(self, table: Table) -> AbstractSystem:
        from martensite.identify.chains.plant import build_plant
        from martensite.scenario.model_files import read_model

        refuse_unknown(table, ("file",), f"[{MODEL}]")
        for other in ("element", "mechanism", GROUP):
            if other in self.document:
                raise ParameterError(f"A scenario has [{MODEL}] or [{other}], not both.")
        if not isinstance(table.get("file"), str):
            raise ParameterError(f'[{MODEL}] needs `file`; write `file = "model.json"`.')
        system = build_plant(read_model(self.folder / str(table["file"])))
        self._read_signals(system)
        names = system.mechanism.signals()
        if self.drive in self.document:
            if len(names) != 1 or self.waveforms:
                raise ParameterError(
                    f"[{self.drive}] is for a model of one input that no [{SIGNALS}] drive; this "
                    f"one has the inputs {', '.join(names)}."
                )
            ((name, unit),) = names.items()
            table = section_of(self.document, self.drive)
            refuse_unknown(table, ("waveform",), f"[{self.drive}]")
            self.waveforms[name] = self._waveform(table, unit, self.drive, name)
        return system

    def _build_single(self, mechanism: AbstractMechanism) -> System:
        if GROUP in self.document:
            raise ParameterError(
                f"Mechanism `{mechanism.registered_name}` takes one element, described in "
                f"[element]; there are no [{GROUP}]."
            )
        if SUPPLY in self.document:
            raise ParameterError(
                f"[{SUPPLY}] is shared by several sources, but `{mechanism.registered_name}` takes one element; "
                f"write its limits under [{self.drive}]."
            )
        actuator = self._build_actuator(self.document, "", DRIVE, not self.controlled)
        return System(mechanism=mechanism, **actuator)

    def _build_machine(self, mechanism: AbstractMechanism, ports: tuple[str, ...]) -> Machine:
        own = section_of(self.document, GROUP, {})
        for name in own:
            if name not in ports:
                raise ParameterError(
                    f"[{GROUP}.{name}]: `{mechanism.registered_name}` has no port of that name. "
                    f"{suggest_name(name, ports)}"
                )
        members: dict[str, Actuator] = {}
        for port in ports:
            path = f"{GROUP}.{port}"
            different = as_table(own.get(port, {}), path)
            common = (*COMMON, self.drive)
            refuse_unknown(different, common, f"[{path}]")
            tables = {
                name: _overlay_table(section_of(self.document, name, {}), different.get(name, {}), path)
                for name in common
            }
            members[port] = Actuator(**self._build_actuator(tables, f"{path}.", port, False))
        supply = section_of(self.document, SUPPLY, {})
        if not supply:
            return Machine(mechanism=mechanism, group=Group(**members))
        shared = Builder(origins=self.origins).build(SharedSupply, supply, SUPPLY)
        return Machine(mechanism=mechanism, group=Group(**members), supply=shared)

    def _build_actuator(self, tables: Table, prefix: str, drive: str, driven: bool) -> dict[str, Any]:
        element = section_of(tables, "element")
        material = self._material(element)
        table = section_of(tables, self.drive)
        path = f"{prefix}{self.drive}"
        source = Builder(origins=self.origins, extra=("waveform",)).choose(
            SOURCES, {key: value for key, value in table.items() if key != "waveform"}, path
        )
        if driven or "waveform" in table:
            self.waveforms[drive] = self._waveform(table, source.unit, path, drive)
        builder = Builder(material, origins=self.origins)
        elements = Builder(material, origins=self.origins, extra=("material",))
        place = f"{prefix}element"
        actuator_element = build_with_plateaus(
            element, place, lambda described: elements.choose(ELEMENTS, described, place, draws=True)
        )
        for caution in (find(material, actuator_element) for find in (law_caution, override_caution, rphase_caution)):
            if caution is not None and caution not in self.cautions:
                self.cautions.append(caution)
        return {
            "element": actuator_element,
            "environment": _build_environment(builder, tables, source.sets_temperature, prefix),
            "source": source,
        }

    def _read_signals(self, system: AbstractSystem) -> None:
        units, tables = system.signals(), section_of(self.document, SIGNALS, {})
        for name, table in tables.items():
            if name not in units:
                raise ParameterError(
                    f"[{SIGNALS}.{name}]: `{system.mechanism.registered_name}` has no signal of that "
                    f"name. {suggest_name(name, units)}"
                )
            path = f"{SIGNALS}.{name}"
            self.waveforms[name] = self._waveform({"waveform": table}, units[name], path, name)

    def _material(self, element: Table) -> Material | None:
        name = element.get("material")
        if name is None:
            return None
        if not isinstance(name, str):
            raise ParameterError(f"[element] `material` must be a name or file, but is {name!r}.")
        with name_section("element"):
            material = load_material(name, self.folder)
        self.material = self.material or material
        return material

    def _waveform(self, drive: Table, unit: str, path: str, name: str) -> AbstractWaveform:
        """Return the waveform of a drive."""
        if "waveform" not in drive:
            kinds = suggest_name("", WAVEFORMS.names())
            raise ParameterError(f"[{path}] needs `waveform`; none given. {kinds}")
        below = path if path.startswith(SIGNALS) else f"{path}.waveform"
        return self.waveform_of(drive["waveform"], unit, below, name)

    def waveform_of(self, given: Any, unit: str, below: str, name: str) -> AbstractWaveform:
        """Return the waveform that a table describes, with levels in a unit."""
        table = as_table(given, below)
        if table.get("kind") == recorded_waveforms.KIND:
            waveform, end = recorded_waveforms.build_waveform(table, below, self.folder, unit)
            self.end = end if math.isinf(self.end) else max(self.end, end)
            return waveform
        if table.get("kind") == recorded_waveforms.LOG:
            return self._build_followed(table, unit, below, name)
        if "kind" in table:
            with name_section(below):
                require_unit(WAVEFORMS[str(table["kind"])], unit)
        builder = Builder(scales=PlaceUnits(unit), origins=self.origins)
        return builder.choose(WAVEFORMS, table, below)

    def _build_followed(self, table: Table, unit: str, path: str, name: str) -> AbstractWaveform:
        """Return the waveform that follows a column of the log."""
        switched = unit == "1" and not path.startswith(SIGNALS)
        natural = recorded_waveforms.DUTY if switched else recorded_waveforms.NATURAL.get(unit, name)
        waveform, self.follows[name] = recorded_waveforms.build_followed(
            table, path, self.log, unit, natural, self.lead
        )
        if self.log is not None:
            last = recorded_waveforms.from_zero(self.log, self.lead).times[-1].item()
            self.end = last if math.isinf(self.end) else max(self.end, last)
        return waveform


def section_of(document: Table, name: str, default: Table | None = None) -> dict[str, Any]:
    """Return a section of a scenario.

    Raises:
        ParameterError: the section is missing and has no default.
    """
    if name not in document and default is None:
        raise ParameterError(f"The scenario needs a section [{name}]; none given.")
    return as_table(document.get(name, default), name)


def drive_section(document: Table) -> str:
    """Return the name of the section of the source, `drive` or `driver`.

    Raises:
        ParameterError: a scenario has both.
    """
    ports = [p for p in section_of(document, GROUP, {}).values() if isinstance(p, dict)]
    names = [name for name in (DRIVE, DRIVER) if any(name in t for t in (document, *ports))]
    if len(names) == 2:
        raise ParameterError(f"A scenario has [{DRIVE}] or [{DRIVER}], not both.")
    return names[0] if names else DRIVE


def scenario_path(path: str, drive: str = DRIVE) -> str:
    """Return the path of a number of the system in a scenario, such as `drive.supply`."""
    members = f"{GROUP}." if path.startswith("group.") else ""
    path = path.removeprefix("group.")
    head, dot, rest = path.partition("source.")
    return members + (f"{head}{drive}.{rest}" if dot and head.count(".") <= 1 else path)


def waveform_path(system: AbstractSystem, name: str, drive: str = DRIVE) -> str:
    """Return the path of the waveform of a drive in a scenario, with its dot."""
    if name in system.signals():
        return f"{SIGNALS}.{name}."
    return f"{drive}.waveform." if name == DRIVE else f"{GROUP}.{name}.{drive}.waveform."


def _build_environment(builder: Builder, tables: Table, sets_temperature: bool, prefix: str) -> Environment:
    table = section_of(tables, "environment", {})
    if sets_temperature and "cooling" not in table:
        table = {**table, "cooling": {"kind": "constant", "h": "0 W/m^2/K"}}
    return builder.build(Environment, table, f"{prefix}environment")


def _overlay_table(common: Mapping[str, Any], different: Any, path: str) -> dict[str, Any]:
    """Return a table with the entries of another over its own; another kind replaces the table."""
    over = as_table(different, path)
    if "kind" in over and over["kind"] != common.get("kind"):
        return over
    merged = dict(common)
    for key, value in over.items():
        below = merged.get(key)
        if isinstance(below, dict) and isinstance(value, dict):
            value = _overlay_table(cast("dict[str, Any]", below), value, f"{path}.{key}")
        merged[key] = value
    return merged
