"""Scenario files: a TOML document gives a system, a waveform and the settings of a run.

The sections are [element], [environment], [mechanism], [drive] with its waveform, [run], and optionally `title`,
[actuators] and [signals] (`martensite.scenario.assemble`), [initial] (`martensite.simulate.initial`), a bench such as
[sensor] and [controller] (`martensite.scenario.bench`), and [measured], a record to compare with. Quantities are text
with a unit. An unknown name is an error that suggests the nearest valid one.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from martensite.actuators.assembly import AbstractSystem, System
from martensite.base.errors import InputError, ParameterError
from martensite.base.files import read_text_file, toml_document
from martensite.base.formats import write_quantity
from martensite.base.lazy import import_extra
from martensite.base.parameters import Leaf, Parametrised
from martensite.base.services import import_service
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.base.toml_text import as_toml
from martensite.physics.materials.base import Material
from martensite.scenario import recorded_waveforms
from martensite.scenario.assemble import Assembly, section_of
from martensite.scenario.build import Builder, Table, refuse_unknown
from martensite.scenario.overrides import change_document
from martensite.scenario.places import Places
from martensite.scenario.recorded_waveforms import Recorded
from martensite.scenario.run_section import Run
from martensite.scenario.sections import SECTIONS as BENCH_SECTIONS
from martensite.scenario.sections import check_sections, has_controllers, is_bench
from martensite.signals.base import AbstractWaveform
from martensite.signals.edges import require_countable
from martensite.simulate.drive_waveforms import Waveforms
from martensite.simulate.restarts import HOME, Restart

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.search.free_numbers import Target
    from martensite.signals.records import Record
    from martensite.simulate.result import Result

SECTIONS = (
    "title",
    "element",
    "environment",
    "mechanism",
    "drive",
    "driver",
    "actuators",
    "signals",
    "supply",
    "model",
    "initial",
    "run",
    "measured",
    *BENCH_SECTIONS,
)


@dataclass(frozen=True)
class Scenario:
    """Complete description of a run, with the origins of its numbers."""

    system: AbstractSystem
    """`System` of one element, `Machine` of several, or plant of a model."""
    waveform: Waveforms
    """Waveform of the drive, or waveforms by name; none for a drive of a controller."""
    duration: float
    """[s]"""
    tolerance: float
    samples: int
    step: float | None
    """Longest step [s], or None for steps by tolerance."""
    title: str
    text: str
    """Document, with overrides."""
    path: Path | None
    material: Material | None
    measured: Recorded | None = None
    """Record to compare with."""
    origins: dict[str, str] = field(default_factory=dict[str, str])
    """Origin by dotted path: `scenario`, `default`, or the kind of number and name of the material."""
    lead: float = 0.0
    """Time before the followed log [s]."""
    follows: dict[str, str] = field(default_factory=dict[str, str])
    """Followed column of the log, by drive."""
    remarks: list[str] = field(default_factory=list[str])
    """Sentences on the assembly of the parts."""
    bench: Bench | None = None
    """System with sensors, observers, controllers and faults, if there are any."""
    seed: int | None = None
    """Seed of the noise on the bench; None without noise."""
    places: Places = field(default_factory=Places)
    """Places of the numbers of the system or bench in the document."""
    initial: dict[str, Any] = field(default_factory=dict[str, Any])
    """Initial quantities in SI, or requests to find them; empty for the home position at rest."""
    restart_at: tuple[float, ...] = ()
    """Times [s] at which the result keeps a state."""
    start: Restart | None = None
    """Restart from which the run continues; None for a start at time 0."""

    def summary(self) -> Summary:
        """Return the simulated system, the duration, and every number with its origin."""
        drive = "no drive" if not self.waveform else f"drive {self.waveform!r}"
        steps = f"tolerance {self.tolerance:g}" if self.step is None else f"steps of at most {self.step:g} s"
        sentences = [
            Sentence(f"{self.whole.description()}; {shorten(drive, 120)}"),
            Sentence(f"duration {self.duration:g} s, {self.samples} samples, {steps}"),
            *(Sentence(one, "caution") for one in self.cautions),
        ]
        leaves = list(self.leaves())
        rows = [
            (f"`{one.path}`", write_quantity(one.value, one.declared.unit), self.origins.get(one.path, ""))
            for one in leaves
        ]
        data = {one.path: one.value for one in leaves}
        table = DataTable(("number", "value", "origin"), rows, right=(1,))
        return Summary("", [*sentences, table], data, f"Scenario `{self.title}`")

    def __repr__(self) -> str:
        """Return a few lines; `summary()` has every number."""
        return self.summary().brief()

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()

    @property
    def whole(self) -> AbstractSystem:
        """Return the simulated system: the bench, or the system alone."""
        return self.system if self.bench is None else self.bench

    @property
    def single_system(self) -> System:
        """Return the system, of one element.

        Raises:
            InputError: it has several elements, or none.
        """
        if not isinstance(self.system, System):
            raise InputError(f"Scenario `{self.title}` has no system of one element.")
        return self.system

    @property
    def single_waveform(self) -> AbstractWaveform:
        """Return the waveform of the only drive.

        Raises:
            InputError: there are several drives, or none has a waveform.
        """
        if not isinstance(self.waveform, AbstractWaveform):
            raise InputError(f"Scenario `{self.title}` has no single waveform.")
        return self.waveform

    def parts(self) -> Iterator[Parametrised]:
        """Yield all components."""
        yield from self.whole.tree()

    def leaves(self) -> Iterator[Leaf]:
        """Yield all numbers of the system or bench."""
        yield from self.whole.leaves()

    @property
    def cautions(self) -> list[str]:
        """Return sentences about allowed but unusual values."""
        return list(dict.fromkeys([*self.remarks, *(c for part in self.parts() for c in part.cautions())]))

    def run(
        self,
        *,
        tolerance: float | None = None,
        runtime: str | None = None,
        budget: float | None = None,
        tell: Callable[[str, float], None] | None = None,
    ) -> Result:
        """Simulate the scenario.

        Args:
            tolerance: replaces the value of the scenario; ignored on a bench.
            runtime: `auto`, `floats` or `c`, by default `auto`, or on a bench `c` with a compiler.
            budget: CPU time [s] after which the run is given up.
            tell: called with the current activity and the finished fraction; not on a bench.
        """
        if self.bench is not None:
            return self._run_bench(self.bench, runtime, budget)
        from martensite.simulate.api import simulate

        chosen, accepted = runtime or "auto", self.tolerance if tolerance is None else tolerance
        result = simulate(
            self.system,
            self.waveform,
            self.duration,
            tolerance=accepted,
            step=self.step if tolerance is None else None,
            samples=self.samples,
            runtime=chosen,
            budget=budget,
            tell=tell,
            start=self.find_start(accepted),
            restart_at=self.restart_at,
        )
        if (interval := self.system.sample_time()) > 0.0:
            from martensite.control.loop.run import warn_of_end

            return warn_of_end(result, self.duration, interval)
        return result

    def require_home(self, what: str) -> Scenario:
        """Return the scenario, or raise `InputError` if it does not start at home and at rest."""
        if self.initial or self.start is not None:
            raise InputError(
                f"{what} needs a start at home and in the steady state. Remove [initial] from the scenario."
            )
        return self

    def find_start(self, tolerance: float) -> Restart:
        """Return the initial state; raise `InputError` if the system cannot take it or the search fails."""
        if self.start is None and self.initial:
            from martensite.simulate.initial import find_start

            return find_start(self.system, self.waveform, self.initial, tolerance)
        return self.start or HOME

    def equal_step(self) -> float:
        """Return the longest equal step within the tolerance [s]."""
        from martensite.simulate.trial_runs import find_step

        case = self.system, self.waveform, self.duration
        return find_step(*case, self.tolerance, self.samples).step

    def write_changed(self, numbers: Mapping[str, float], lead: str) -> str:
        """Return the scenario with other numbers as TOML, after a comment.

        Args:
            numbers: values [SI] by path in the system or bench.
            lead: text of the comment.
        """
        values = {self.places.path(path): float(value) for path, value in numbers.items()}
        return f"# {lead}\n\n{as_toml(change_document(tomllib.loads(self.text), values))}"

    def find_target(self, name: str) -> Target:
        """Return the variable number of a path, or of its unique ending.

        Raises:
            ParameterError: the name is unknown or ambiguous.
        """
        from martensite.scenario.targets import list_targets
        from martensite.search.free_numbers import find_alike

        return find_alike(name, [*list_targets(self).values()], several=False)[0]

    def show_bench(self) -> Any:
        """Return the web bench as a notebook widget; `InputError` without the extra `notebook`."""
        import_extra("anywidget", "notebook", "the bench in a notebook")
        return import_service("make_bench_widget")(self)

    def _run_bench(self, bench: Bench, runtime: str | None, budget: float | None) -> Result:
        from martensite.control.loop.run import simulate_bench
        from martensite.simulate.drive_waveforms import by_name

        return simulate_bench(
            bench,
            self.duration,
            seed=self.seed,
            runtime=runtime,
            budget=budget,
            waveforms=by_name(self.system, self.waveform),
            start=self.start or HOME,
            restart_at=self.restart_at,
        )


def load(path: str | Path, overrides: Mapping[str, Any] | None = None, *, log: Record | None = None) -> Scenario:
    """Read a scenario file and build it.

    Args:
        path: TOML file; named files are relative to it.
        overrides: values by dotted path, such as `{"element.diameter": "0.25 mm"}`.
        log: record that waveforms of kind `log` follow from its first row.

    Raises:
        InputError: the file is missing or malformed, or a value is invalid.
    """
    path = Path(path)
    return read_scenario(read_text_file(path, "scenario"), path, overrides, log=log)


def read_scenario(
    text: str, path: Path | None = None, overrides: Mapping[str, Any] | None = None, *, log: Record | None = None
) -> Scenario:
    """Build the text of a scenario; `path` is its file, and `log` as for `load`."""
    if "\n" not in text and text.endswith(".toml"):
        raise InputError(
            f"`read_scenario` takes the text of a scenario, but was given a path; use `ms.load({text!r})`."
        )
    document = toml_document(text, f"`{path}`" if path else "The scenario")
    if overrides:
        document = change_document(document, _name_in_full(document, overrides, path, log))
        text = as_toml(document)
    refuse_unknown(document, SECTIONS, "The scenario")
    return _build_scenario(document, text, path, log)


def _name_in_full(
    document: dict[str, Any], overrides: Mapping[str, Any], path: Path | None, log: Record | None
) -> dict[str, Any]:
    """Return overrides by full path; a unique ending such as `diameter` names a number."""
    short = [
        name
        for name, value in overrides.items()
        if name.partition(".")[0] not in SECTIONS and not isinstance(value, dict)
    ]
    if not short:
        return dict(overrides)
    plain = _build_scenario(document, as_toml(document), path, log)
    full = {name: plain.places.path(plain.whole.resolve(name)) for name in short}
    return {full.get(name, name): value for name, value in overrides.items()}


def _build_scenario(document: dict[str, Any], text: str, path: Path | None, log: Record | None) -> Scenario:
    folder = path.parent if path else Path()
    origins: dict[str, str] = {}
    check_sections(document)
    extra = ("period",) if is_bench(document) else ()
    builder = Builder(origins=origins, extra=extra)
    run = builder.build(Run, section_of(document, "run", {}), "run")
    controlled = has_controllers(document)
    assembly = Assembly(document, folder, log, run.lead, origins, controlled=controlled)
    system, places = assembly.system(), Places(assembly.drive)
    bench, noisy = _build_bench(assembly, system, places)
    waveform, duration = assembly.list_waveforms(system), run.find_duration(assembly.end)
    _require_countable_edges(waveform, duration)
    return Scenario(
        system=system,
        waveform=waveform,
        duration=duration,
        tolerance=run.tolerance,
        samples=int(run.samples),
        step=run.step if math.isfinite(run.step) else None,
        title=str(document.get("title", path.stem if path else "scenario")),
        text=text,
        path=path,
        material=assembly.material,
        measured=_read_measured(document, folder),
        origins=assembly.origins,
        follows=assembly.follows,
        lead=run.lead,
        remarks=assembly.cautions,
        bench=bench,
        seed=int(run.seed) if noisy else None,
        places=places,
        initial=_read_initial(document, system if bench is None else bench),
        restart_at=run.list_restarts(),
    )


def _read_initial(document: Table, system: AbstractSystem) -> dict[str, Any]:
    """Return the initial conditions of the document."""
    if "initial" not in document:
        return {}
    from martensite.simulate.initial import read_initial

    return read_initial(system, section_of(document, "initial"), with_units=True)


def _require_countable_edges(waveform: Waveforms, duration: float) -> None:
    """Raise an error if a waveform has too many edges."""
    for one in [waveform] if isinstance(waveform, AbstractWaveform) else waveform.values():
        for part in one.tree():
            if isinstance(part, AbstractWaveform):
                require_countable(part.registered_name, part.count_edges(duration), duration)


def _build_bench(assembly: Assembly, plant: AbstractSystem, places: Places) -> tuple[Bench | None, bool]:
    """Return the bench around a system, or None, and true if its sensors have noise."""
    if not is_bench(assembly.document):
        if section_of(assembly.document, "run", {}).get("seed", 0) not in (0, "0"):  # forms write the default
            raise ParameterError("[run] `seed` has no effect, since there is no [sensor] that has noise; remove it.")
        return None, False
    from martensite.scenario.bench import BenchBuilder

    return BenchBuilder(assembly, plant, places).build()


def _read_measured(document: Table, folder: Path) -> Recorded | None:
    if "measured" not in document:
        return None
    return recorded_waveforms.read_recorded(section_of(document, "measured"), "measured", folder)
