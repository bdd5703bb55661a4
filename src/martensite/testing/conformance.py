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
from martensite.physics.materials.base import Material, load_material, material_names
from martensite.scenario.catalogue import list_registries
from martensite.simulate.provenance import keep_record
from martensite.studies.base import AbstractStudy, load_study, study_names
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


def check_conformance(cls: type[Parametrised], kind: str, parts: Iterable[Parametrised] = ()) -> Conformance:
    """Run the suite of a kind on a part, and keep the result for the remarks of later runs.

    Examples of it are by default made of typical values, one for every choice of options.

    Raises:
        InputError: no suite exists for this kind.
        ParameterError: no example can be built from its declarations.
    """
    if kind not in SUITES:
        raise InputError(f"There is no suite for the kind `{kind}` of `{cls.registered_name}`.")
    checks = find_checks(kind, cls)
    found = [check_part(part, check) for part in (list(parts) or list_variants(cls)) for check in checks]
    report = Conformance(cls.registered_name or cls.__name__, kind, tuple(found))
    keep_record(cls, report.holds, len(checks))
    return report


def check_material(name: str | Path) -> Conformance:
    """Run the suite of materials on one material, by its name or its file.

    Raises:
        InputError: the material does not exist, or its file is malformed.
    """
    material = load_material(name)
    found = [check_part(material, check) for check in find_checks("material", Material)]
    return Conformance(material.name, "material", tuple(found))


def check_study(name: str) -> Conformance:
    """Run the suite of studies on one, by its name.

    Raises:
        InputError: the study does not exist, or its files cannot be read.
    """
    study = load_study(name)
    found = [check_part(study, check) for check in find_checks("study", AbstractStudy)]
    return Conformance(study.key, "study", tuple(found))


def check_target(target: str) -> list[Conformance]:
    """Run the suites on all that a name, a `.py` file or the `.toml` file of a material stands for.

    Raises:
        InputError: the part does not exist, the file registers no part, or it cannot be read.
    """
    if target.endswith(".toml") or target in material_names():
        return [check_material(target)]
    try:
        return [check_conformance(cls, kind) for kind, cls in find_parts(target)]
    except UnknownNameError as error:
        if target in study_names():
            return [check_study(target)]
        raise error from None


def find_parts(target: str) -> list[tuple[str, type[Parametrised]]]:
    """Find kind and class of the parts that a name stands for, or that a file registers.

    Raises:
        InputError: the part does not exist, the file registers no part, or it cannot be imported.
    """
    known = list_registries(blocks=True)
    if target.endswith(".py"):
        import_modules([target])
        module = Path(target).stem
        found = [(k, r[n]) for k, r in known.items() for n in r.names()]
        own = [(kind, cls) for kind, cls in found if cls.__module__ == module]
        if not own:
            raise InputError(
                f'`{target}` registers no part; write, for example, `@LAWS.register("my-law")` above a class of it.'
            )
        return own
    own = [(kind, r[target]) for kind, r in known.items() if target in r.names()]
    if not own:
        names = [n for r in known.values() for n in r.names()]
        raise UnknownNameError("part", target, [*names, *material_names()])
    return own


def check_part(part: Parametrised | Material | AbstractStudy, check: Check) -> Finding:
    """Return the finding of one check on one part; an error in the code of the part is a fault too."""
    label = (
        label_part(part) if isinstance(part, Parametrised) else part.name if isinstance(part, Material) else part.key
    )
    promise = (check.__doc__ or "").partition("\n")[0]
    try:
        check(part)
    except ConformanceError as error:
        fault = str(error)
    except Exception as error:  # whatever a user's code raises
        fault = f"it raised {type(error).__name__}: {error}"
    else:
        fault = ""
    return Finding(label, check.__name__, promise, fault)
