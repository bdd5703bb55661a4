"""Conformance of parts to their interfaces: suites of checks, one for every kind of part.

A check is a function of a part, or of a material, that raises `ConformanceError` with a sentence.
Parts are tried as made of their typical values, once for every choice of every option.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

from martensite.base.errors import InputError, MartensiteError, UnknownNameError
from martensite.base.parameters import Parametrised
from martensite.base.registry import import_modules
from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS
from martensite.physics.materials.base import load_material, material_names
from martensite.scenario.catalogue import LISTS, list_registries
from martensite.simulate.provenance import keep_record
from martensite.studies import base as studies
from martensite.testing.examples import label_part, list_variants

Check = Callable[[Any], None]
SUITES = {
    "law": "laws",
    "cooling": "elements",
    "ends": "elements",
    "fluid": "elements",
    "resistance": "elements",
    "drive": "elements",
    "element": "elements",
    "mechanism": "mechanisms",
    "waveform": "waveforms",
    "sensor": "sensors",
    "observer": "observers",
    "controller": "controllers",
    "supervisor": "supervisors",
    "check": "supervisors",
    "fault": "faults",
    "block": "blocks",
    "measure": "waveforms",
    "material": "materials",
    "study": "studies",
    "experiment": "experiment_kinds",
    "command": "commands",
    "exporter": "exporters",
}
"""Kind of a part -> module of this package that has its suite."""


class ConformanceError(MartensiteError):
    """A part does not do what its interface promises."""


def require_condition(condition: object, sentence: str) -> None:
    """Raise `ConformanceError` unless a condition holds."""
    if not condition:
        raise ConformanceError(sentence)


@dataclass(frozen=True)
class Finding:
    """Result of one check on one part."""

    part: str
    """Name and options."""
    check: str
    """Name of the check."""
    promise: str
    """Promise in words."""
    fault: str = ""
    """Fault, in a sentence; empty without a fault."""


@dataclass(frozen=True)
class Conformance:
    """Results of a suite on a part."""

    name: str
    kind: str
    findings: tuple[Finding, ...]

    @property
    def holds(self) -> bool:
        """Return whether checks were made, and all of them passed."""
        return bool(self.findings) and not self.faults

    @property
    def faults(self) -> list[Finding]:
        """Return the findings with a fault."""
        return [one for one in self.findings if one.fault]

    def __str__(self) -> str:
        """In a line."""
        checks = len({one.check for one in self.findings})
        if not checks:
            return f"{self.kind} `{self.name}` was not tried: no check of the suite is about it"
        if self.holds:
            return f"{self.kind} `{self.name}` conforms: {checks} checks passed"
        failed = len({one.check for one in self.faults})
        return f"{self.kind} `{self.name}` does not conform: {failed} of {checks} checks failed"


def find_checks(kind: str, cls: type[Any]) -> list[Check]:
    """Return the suite of a kind of part, such as `law`, for a class of it; empty if there is none.

    These are the functions `check_…` of its module whose argument is of the class, or of one above
    it: what holds for some of a kind is a check of their common class.
    """
    if kind not in SUITES:
        return []
    module = import_module(f"martensite.testing.{SUITES[kind]}")
    own = [one for name, one in vars(module).items() if name.startswith("check_") and one.__module__ == module.__name__]
    return [one for one in own if issubclass(cls, next(iter(get_type_hints(one).values())))]


def check_conformance(cls: type[Any], kind: str, parts: Iterable[Any] = ()) -> Conformance:
    """Run the suite of a kind on a part; keep the result for the remarks of later runs.

    Args:
        cls: class of the part.
        kind: kind of the part, such as `law`.
        parts: examples; by default made of typical values, one for every choice of options.

    Raises:
        InputError: no suite exists for this kind.
        ParameterError: no example can be built from its declarations.
    """
    if kind not in SUITES:
        raise InputError(f"There is no suite for the kind `{kind}` of `{cls.registered_name}`.")
    declared = issubclass(cls, Parametrised)
    tried = list(parts) or (list_variants(cls) if declared else [cls()])
    report = Conformance(cls.registered_name or cls.__name__, kind, tuple(_try_all(kind, tried)))
    if declared:
        keep_record(cls, report.holds, len({one.check for one in report.findings}))
    return report


def check_command(command: Any, name: str, kind: str = "command") -> Conformance:
    """Run the suite of commands on a command of Typer, and that of exporters on an exporter.

    Args:
        command: the command.
        name: words that call it, such as `export c`.
        kind: `command` or `exporter`.
    """
    suites = dict.fromkeys(("command", kind))
    return Conformance(name, kind, tuple(one for suite in suites for one in _try_all(suite, [command])))


def _try_all(kind: str, parts: Iterable[Any]) -> list[Finding]:
    return [check_part(part, check) for part in parts for check in find_checks(kind, type(part))]


def check_material(name: str | Path) -> Conformance:
    """Run the suite of materials on one material, by its name or its file.

    Raises:
        InputError: the material does not exist, or its file is malformed.
    """
    material = load_material(name)
    return Conformance(material.name, "material", tuple(_try_all("material", [material])))


def check_target(target: str, others: Iterable[str] = (), required: bool = True) -> list[Conformance]:
    """Run the suites on all parts that a name, a `.py` file or the `.toml` file of a material stands for.

    Args:
        target: the name or the file.
        others: further valid names, for the message.
        required: False if it is no error that there is no part.

    Raises:
        InputError: the part does not exist, the file registers no part, or it cannot be read.
    """
    if target.endswith(".toml") or target in material_names():
        return [check_material(target)]
    found = find_parts(target)
    if required and not found:
        raise _make_error(target, others)
    return [check_conformance(cls, kind) for kind, cls in found]


def find_parts(target: str) -> list[tuple[str, type[Any]]]:
    """Return kind and class of the parts that a name stands for, or that a file registers; empty if there are none.

    Raises:
        InputError: the file cannot be imported.
    """
    kinds = list_registries(blocks=True) | {"experiment": EXPERIMENT_KINDS}
    if target.endswith(".py"):
        import_modules([target])
        found = [(kind, r[name]) for kind, r in kinds.items() for name in r.names()]
        return [(kind, cls) for kind, cls in found if cls.__module__ == Path(target).stem]
    own = [(kind, r[target]) for kind, r in kinds.items() if target in r.names()]
    return own or [("study", studies.STUDIES[name]) for name in studies.STUDIES.names() if name == target]


def _make_error(target: str, others: Iterable[str]) -> InputError:
    if target.endswith(".py"):
        return InputError(
            f'`{target}` registers no part; write, for example, `@LAWS.register("my-law")` above a class of it.'
        )
    registries = *list_registries(blocks=True).values(), EXPERIMENT_KINDS, studies.STUDIES
    names = {*others, *material_names(), *(name for one in registries for name in one.names())}
    where = f"{LISTS}, `martensite study` lists studies, `martensite --help` commands"
    return UnknownNameError("part, material, study or command", target, names, where)


def check_part(part: Any, check: Check) -> Finding:
    """Return the finding of one check on one part; an error in the code of the part is a fault too."""
    promise = (check.__doc__ or "").partition("\n")[0]
    try:
        check(part)
    except ConformanceError as error:
        fault = str(error)
    except Exception as error:  # whatever a user's code raises
        fault = f"it raised {type(error).__name__}: {error}"
    else:
        fault = ""
    return Finding(_label(part), check.__name__, promise, fault)


def _label(part: Any) -> str:
    if isinstance(part, Parametrised):
        return label_part(part)
    return str(getattr(part, "registered_name", "") or getattr(part, "name", type(part).__name__))
