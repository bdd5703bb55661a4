"""The benches of scenarios: sensors, observers, controllers and faults around a system.

    [sensor]      or [sensors.NAME]       kind, its parameters, and how it is mounted
    [observer]    or [observers.NAME]     kind and parameters; `model` is the model it uses
    [controller]  or [controllers.DRIVE]  kind and parameters; period, limits
    [reference]   or [references.DRIVE]   a waveform in any unit of the measured quantity
    [supervisor], [faults.NAME]           kind and parameters
    [bench]                               period, steps, switching, noise

A `follower` whose leader follows no reading needs no reference.

The model of an observer or controller is the system of the scenario. `model = { "element.diameter" = "0.37 mm" }`
changes it (`model_changes`), and [observer.models.NAME] holds the changes of a further model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from martensite.base.errors import ParameterError, suggest_name
from martensite.base.interfaces import override
from martensite.base.parameters import Number, Parametrised, option, param
from martensite.control.controllers.base import CONTROLLERS, PLANNED, AbstractController, require_readings
from martensite.control.controllers.follower import Follower
from martensite.control.faults.base import FAULTS as KNOWN_FAULTS
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_readings
from martensite.control.loop.parts import (
    SUPERVISORS,
    AbstractSupervisor,
    Controllers,
    FaultTable,
    MountedSensor,
    Observers,
    Sensors,
)
from martensite.control.observers.base import OBSERVERS
from martensite.control.sensors.base import SENSORS
from martensite.scenario.assemble import Assembly, section_of
from martensite.scenario.build import Builder, Table, choose_class, name_section
from martensite.scenario.components import gather_nested
from martensite.scenario.guard import GUARD, KIND, NONE, complete_guard
from martensite.scenario.model_changes import change_parts, list_changes
from martensite.scenario.place_units import PlaceUnits
from martensite.scenario.places import Places
from martensite.scenario.sections import (
    BENCH,
    FAULTS,
    MODEL,
    MODELS,
    NAME,
    PAIRS,
    PERIOD,
    REFERENCE,
    RUN,
    SECTIONS,
    SUPERVISOR,
    Row,
    check_name,
    list_rows,
)
from martensite.signals.constant import Constant

if TYPE_CHECKING:
    from martensite.actuators.assembly import AbstractSystem
    from martensite.control.faults.base import AbstractFault
    from martensite.control.observers.base import AbstractObserver
    from martensite.control.sensors.base import AbstractSensor

CONTROLLER = "controller"
READING = "reading"
"""Name of the reading of a sensor."""


class BenchSettings(Parametrised):
    """Settings of a bench."""

    period: Number = param("s", "time from one sample to the next", above=0.0, default=math.inf)
    substeps: Number = param(
        "1", "steps of the system in a period; 0: as many as it needs", low=0.0, high=1e6, default=0.0
    )
    switching: str = option(
        "a switch (`pwm-voltage`): averaged over the period, or closed from its start for the "
        "share of it that the signal says",
        "averaged",
        "pulses",
        default="averaged",
    )
    noise: str = option("random numbers of the sensors", "drawn", "none", default="drawn")

    @override
    def check(self) -> None:
        if self.substeps != int(self.substeps):
            raise ParameterError(f"`substeps` must be a whole number, but is {self.substeps}.")


@dataclass(frozen=True)
class BenchBuilder:
    """Builder of the bench around a plant; it notes origins and places of all numbers."""

    assembly: Assembly
    plant: AbstractSystem
    """Plant of the bench."""
    places: Places

    def build(self) -> tuple[Bench, bool]:
        """Return the bench, and true if its sensors have noise.

        Raises:
            InputError: a section, a name or a value does not fit.
        """
        document, settings = self.assembly.document, self._settings()
        self.places.note_system("plant", "")
        bench = Bench(
            plant=self.plant,
            period=settings.period,
            switching=settings.switching,
            substeps=int(settings.substeps),
            sensors=Sensors(**dict(map(self._sensor, list_rows(document, "sensor")))),
        )
        observers = dict(self._observer(bench, row) for row in list_rows(document, "observer"))
        bench = bench.with_parts(observers=Observers(**observers))
        controllers = dict(self._controller(bench, row) for row in list_rows(document, CONTROLLER))
        _check_references(document, controllers)
        faults = dict(self._fault(bench, row) for row in list_rows(document, FAULTS))
        bench = bench.with_parts(
            controllers=Controllers(**controllers),
            supervisor=self._supervisor(bench, controllers),
            faults=FaultTable(**faults),
        )
        return bench, settings.noise == "drawn"

    def _settings(self) -> BenchSettings:
        """Return the settings, with the period from the section that has it."""
        document, origins = self.assembly.document, self.assembly.origins
        stands = {
            path: own[PERIOD] for path in (CONTROLLER, BENCH, RUN) if PERIOD in (own := section_of(document, path, {}))
        }
        if len(stands) != 1:
            where = " and ".join(f"[{path}]" for path in stands)
            fault = f"`period` stands in {where}; leave one" if where else "A bench needs `period`"
            raise ParameterError(
                f'{fault}: write `period = "20 ms"`, the time from one sample to the next, in '
                f"[{CONTROLLER if CONTROLLER in document else BENCH}]."
            )
        if "seed" in section_of(document, BENCH, {}):
            raise ParameterError(f"`seed` does not stand in [{BENCH}]; write it in [{RUN}], such as `seed = 1`.")
        ((path, given),) = stands.items()
        table = {**section_of(document, BENCH, {}), PERIOD: given}
        settings: BenchSettings = Builder(origins=origins).build(BenchSettings, table, BENCH)
        self.places.note(PERIOD, f"{path}.{PERIOD}")
        origins[f"{path}.{PERIOD}"] = "scenario"
        return settings

    def _component(
        self, cls: type[Parametrised], row: Row, scales: PlaceUnits, extra: tuple[str, ...] = (), **parts: object
    ) -> Any:
        """Return a component from a row with its path in the bench."""
        where, table, path = row
        origins = self.assembly.origins
        builder = Builder(scales=scales, origins=origins, extra=extra, plain=True, ready_components=parts)
        part = builder.build(cls, table, path)
        self.places.note(where, path, scales)
        self.places.note_scales(where, part, scales)
        return part

    def _sensor(self, row: Row) -> tuple[str, MountedSensor]:
        """Return the name and the mounted sensor of a row."""
        name, table, path = row
        mount = tuple(n for n in MountedSensor.declarations if n != "sensor")
        names = (NAME,) if path in PAIRS else ()
        cls = cast("type[AbstractSensor]", choose_class(SENSORS, table, path))
        given = {key: value for key, value in table.items() if key in mount}
        quantities = _list_texts(given.get("of")) or list(cls.sees)
        outputs = self.plant.outputs()
        first = outputs[quantities[0]].unit if quantities and quantities[0] in outputs else "1"
        unit = cls.unit or first
        natural = quantities[0].replace(".", "_") if quantities and unit == first else str(table["kind"])
        name = name or str(table.get(NAME, natural.replace("-", "_")))
        where = f"sensors.{check_name(name, path)}"
        scales = PlaceUnits(readings={READING: unit}, reading_names=(READING,))
        sensor = self._component(cls, (f"{where}.sensor", table, path), scales, (*mount, *names))
        return name, self._component(MountedSensor, (where, given, path), scales, sensor=sensor)

    def _observer(self, bench: Bench, row: Row) -> tuple[str, AbstractObserver]:
        name, table, path = row
        cls = choose_class(OBSERVERS, table, path)
        name = check_name(name or str(table["kind"]).replace("-", "_"), path)
        where = f"observers.{name}"
        models = self._model(cls, table, path, where)
        scales = PlaceUnits(readings=_list_units(bench))
        return name, self._component(cls, (where, table, path), scales, tuple(models), **models)

    def _model(self, cls: type[Parametrised], table: Table, path: str, where: str) -> dict[str, Any]:
        """Return the models of a component by declaration; empty for a component without a model."""
        declared = cls.declarations.get(MODEL)
        if declared is None or declared.kind != "part" or declared.registry is not None:
            return {}
        own = table.get(MODEL, {})
        models: dict[str, Any] = {MODEL: self._changed_plant((own,), f"{path}.{MODEL}", f"{where}.{MODEL}")}
        several = cls.declarations.get(MODELS)
        if several is not None and MODELS in table:
            rows: Any = table[MODELS]
            if not isinstance(rows, dict):
                raise ParameterError(f"[{path}] `{MODELS}` must be tables by name, such as [{path}.{MODELS}.windy].")
            models[MODELS] = type(several.default)(
                **{
                    check_name(name, path): self._changed_plant(
                        (own, changes), f"{path}.{MODELS}.{name}", f"{where}.{MODELS}.{name}"
                    )
                    for name, changes in cast("Table", rows).items()
                }
            )
        return models

    def _changed_plant(self, changes: tuple[Any, ...], path: str, where: str) -> AbstractSystem:
        """Return the plant with all changes of a model; the last of them are noted under a path."""
        self.places.note_system(where, path)
        if not any(changes):
            return self.plant
        with name_section(path):
            plain = {name: own for name, own in self.assembly.document.items() if name not in SECTIONS}
            for table in changes:
                plain = change_parts(plain, table)
            origins = self.assembly.origins
            written = list_changes(changes[-1])
            origins.update(dict.fromkeys((f"{path}.{key}" for key, _ in written), "scenario"))
            model = replace(self.assembly, document=plain, origins={}, waveforms={}, follows={})
            return model.system()

    def _fault(self, bench: Bench, row: Row) -> tuple[str, AbstractFault]:
        """Return the name and the fault of a row; levels are in the unit of the disturbed quantity."""
        name, table, path = row
        where = f"{FAULTS}.{check_name(name, path)}"
        drives = {drive.name: drive.unit for drive in self.plant.drives()}
        only = next(iter(drives.values())) if len(drives) == 1 else "1"
        scales = PlaceUnits(drives.get(str(table.get("drive"))) or only, _list_units(bench))
        cls = choose_class(KNOWN_FAULTS, table, path)
        return name, self._component(cls, (where, table, path), scales)

    def _supervisor(self, bench: Bench, controllers: Mapping[str, AbstractController]) -> AbstractSupervisor | None:
        document, origins = self.assembly.document, self.assembly.origins
        if SUPERVISOR not in document and not controllers:
            return None
        units = {drive.unit for drive in self.plant.drives()}
        scales = PlaceUnits(units.pop() if len(units) == 1 else "1", _list_units(bench))
        given = section_of(document, SUPERVISOR, {})
        full: Table | None = given
        taken = set[str]()
        if given.get(KIND, GUARD) in (GUARD, NONE):
            noisy = section_of(document, BENCH, {}).get("noise") != "none"
            builder = Builder(scales=scales, origins=origins, plain=True)
            full, taken, cautions = complete_guard(given, bench, controllers, builder, noisy)
            self.assembly.cautions.extend(cautions)
        if full is None:
            return None
        supervisor = self._component(
            choose_class(SUPERVISORS, full, SUPERVISOR), (SUPERVISOR, full, SUPERVISOR), scales
        )
        origins.update(dict.fromkeys(taken & set(origins), "plant"))
        return supervisor

    # ---------------------------------------------------------------- controllers

    def _controller(self, bench: Bench, row: Row) -> tuple[str, AbstractController]:
        name, table, path = row
        name, unit = self._find_drive(name, path)
        given, below = self._find_reference(name, table, path)
        if given is None:  # a reference that the controller does not follow is not a parameter of the scenario
            self.places.note_system(f"controllers.{name}.{REFERENCE}", below)
            return name, self._build_idle(bench, (f"controllers.{name}", table, path), PlaceUnits(unit))
        where, readings = f"controllers.{name}", _list_units(bench)
        built = self._build_idle(bench, (where, table, path), PlaceUnits(unit, readings))
        with name_section(path):
            require_readings(built, [*readings, PLANNED])
            kind = built.reference_unit(readings, unit)
        self.places.note(f"{where}.{REFERENCE}", below, PlaceUnits(kind))
        waveform = self.assembly.waveform_of(given, kind, below, name)
        return name, built.with_parts(reference=waveform)

    def _build_idle(self, bench: Bench, row: Row, scales: PlaceUnits) -> AbstractController:
        """Return a controller with a zero reference."""
        where, table, path = row
        cls = choose_class(CONTROLLERS, table, path)
        parts = {REFERENCE: Constant(level=0.0), **self._model(cls, table, path, where)}
        if PERIOD in cls.declarations:
            table = {**table, PERIOD: f"{bench.period!r} s"}
        full, moved = gather_nested(cls, table)
        extra = (*parts, PERIOD) if path == CONTROLLER else tuple(parts)
        built = self._component(cls, (where, full, path), scales, extra, **parts)
        for inner, flat in moved.items():
            self.places.note(f"{where}.{inner}", f"{path}.{flat}")
            self.assembly.origins[f"{path}.{flat}"] = "scenario"
        return built

    def _find_drive(self, name: str, path: str) -> tuple[str, str]:
        """Return the name and unit of the drive of a controller; by default the only free drive."""
        drives = {drive.name: drive.unit for drive in self.plant.drives()}
        waved = self.assembly.waveforms
        free = [one for one in drives if one not in waved]
        if not name and len(drives) > 1 and len(free) != 1:
            raise ParameterError(
                f"[{path}] It is not clear which of the drives {', '.join(drives)} it has; write "
                f"[{PAIRS[CONTROLLER]}.{(free or list(drives))[0]}]."
            )
        name = name or (list(drives) if len(drives) == 1 else free)[0]
        if name not in drives:
            raise ParameterError(f"[{path}] There is no drive `{name}`. {suggest_name(name, drives)}")
        if name in waved:
            raise ParameterError(f"[{path}] has the drive `{name}`, which has a waveform as well; leave one out.")
        return name, drives[name]

    def _find_reference(self, name: str, table: Table, path: str) -> tuple[Any, str]:
        """Return the reference of a controller and the path of its section."""
        single = path == CONTROLLER
        outer = REFERENCE if single else PAIRS[REFERENCE]
        given = section_of(self.assembly.document, outer, {})
        there = bool(given) if single else name in given
        title = outer if single else f"{outer}.{name}"
        if there and REFERENCE in table:
            raise ParameterError(f"A scenario has [{title}] or [{path}.{REFERENCE}], not both.")
        if REFERENCE in table:
            return table[REFERENCE], f"{path}.{REFERENCE}"
        if not there and table.get("kind") == Follower.registered_name and "measured" not in table:
            return None, title
        if not there:
            raise ParameterError(
                f"[{path}] needs a reference; write a section [{title}] with a waveform, such as "
                f'`kind = "constant"` and `level = …`, in a unit of what is measured.'
            )
        return (given if single else given[name]), title


def _check_references(document: Table, controllers: Mapping[str, AbstractController]) -> None:
    single = CONTROLLER in document
    given = section_of(document, PAIRS[REFERENCE], {})
    idle = next((name for name in given if single or name not in controllers), None)
    if idle is not None:
        raise ParameterError(
            f"[references.{idle}] has no effect, since there is no [controllers.{idle}]. "
            f"{suggest_name(idle, [] if single else controllers)}"
        )
    if REFERENCE in document and not single:
        raise ParameterError("[reference] has no effect, since there is no [controller]; write [references.DRIVE].")


def _list_units(bench: Bench) -> dict[str, str]:
    return {name: output.unit for name, output in list_readings(bench).items()}


def _list_texts(given: Any) -> list[str]:
    if isinstance(given, str):
        return [given]
    return [str(one) for one in cast("list[Any]", given)] if isinstance(given, list) else []
