"""Conformance of parts to their interfaces, by one suite of checks per kind of part.

A check is a function of a part that raises `ConformanceError`. Parts are tried with their typical values, once for each
choice of each option.
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
"""Module of the suite, by kind of part."""


class ConformanceError(MartensiteError):
    """A part does not do what its interface promises."""


def require_condition(condition: object, sentence: str) -> None:
    """Raise `ConformanceError` if a condition is false."""
    if not condition:
        raise ConformanceError(sentence)


@dataclass(frozen=True)
class Finding:
    """Result of one check on one part."""

    part: str
    check: str
    promise: str
    fault: str = ""
    """Message; empty if the check passed."""


@dataclass(frozen=True)
class Conformance:
    """Results of a suite on a part."""

    name: str
    kind: str
    findings: tuple[Finding, ...]

    @property
    def holds(self) -> bool:
        """Return whether at least one check was made, and all passed."""
        return bool(self.findings) and not self.faults

    @property
    def faults(self) -> list[Finding]:
        """Return the findings with a fault."""
        return [one for one in self.findings if one.fault]

    def __str__(self) -> str:
        """Return the verdict in one line."""
        checks = len({one.check for one in self.findings})
        if not checks:
            return f"{self.kind} `{self.name}` was not tried: no check of the suite is about it"
        if self.holds:
            return f"{self.kind} `{self.name}` conforms: {checks} checks passed"
        failed = len({one.check for one in self.faults})
        return f"{self.kind} `{self.name}` does not conform: {failed} of {checks} checks failed"


def find_checks(kind: str, cls: type[Any]) -> list[Check]:
    """Return the checks for a class; empty for an unknown kind.

    Checks are the functions `check_…` of the suite whose argument is annotated with the class or a base class of it.
    """
    if kind not in SUITES:
        return []
    module = import_module(f"martensite.testing.{SUITES[kind]}")
    own = [one for name, one in vars(module).items() if name.startswith("check_") and one.__module__ == module.__name__]
    return [one for one in own if issubclass(cls, next(iter(get_type_hints(one).values())))]


def check_conformance(cls: type[Any], kind: str, parts: Iterable[Any] = ()) -> Conformance:
    """Run the suite of a kind on a part, and record the result for the remarks of later runs.

    Args:
        cls: class of the part.
        kind: kind of the part, such as `law`.
        parts: examples; by default one of typical values for each choice of each option.

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
    """Run the suite of commands on a Typer command, and for an exporter also the suite of exporters.

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
    """Run the suite of materials on a material, given by name or file.

    Raises:
        InputError: the material does not exist, or its file is malformed.
    """
    material = load_material(name)
    return Conformance(material.name, "material", tuple(_try_all("material", [material])))


def check_target(target: str, others: Iterable[str] = (), required: bool = True) -> list[Conformance]:
    """Run the suites on the parts of a name, a `.py` file, or the `.toml` file of a material.

    Args:
        target: the name or the file.
        others: further valid names, for the message.
        required: raise an error if there is no part.

    Raises:
        InputError: the part does not exist, the file registers no part, or it cannot be read.
    """
    if target.endswith(".toml") or target in material_names():
        return [check_material(target)]
    parts = find_parts(target)
    if required and not parts:
        raise _make_error(target, others)
    return [check_conformance(cls, kind) for kind, cls in parts]


def find_parts(target: str) -> list[tuple[str, type[Any]]]:
    """Return kind and class of the parts with a name, or of the parts registered in a `.py` file.

    Raises:
        InputError: the file cannot be imported.
    """
    kinds = list_registries(blocks=True) | {"experiment": EXPERIMENT_KINDS}
    if target.endswith(".py"):
        import_modules([target])
        parts = [(kind, r[name]) for kind, r in kinds.items() for name in r.names()]
        return [(kind, cls) for kind, cls in parts if cls.__module__ == Path(target).stem]
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
    """Return the result of one check on one part; an exception of the part counts as a fault."""
    promise = (check.__doc__ or "").partition("\n")[0]
    try:
        check(part)
    except ConformanceError as error:
        fault = str(error)
    except Exception as error:  # user code can raise any exception
        fault = f"it raised {type(error).__name__}: {error}"
    else:
        fault = ""
    return Finding(_label(part), check.__name__, promise, fault)


def _label(part: Any) -> str:
    if isinstance(part, Parametrised):
        return label_part(part)
    return str(getattr(part, "registered_name", "") or getattr(part, "name", type(part).__name__))
