"""`to_fmu`: a scenario or a system as an FMU, FMI 2.0 or 3.0.

It is for co-simulation, and for model exchange too where the law of its only element gives rates.

The FMU holds the model in C with its sources, libraries for the machines that there are compilers for, the
description of everything that can be set, and the scenario that it was made of. The same scenario gives the same
archive: times in it are fixed, and its GUID (instantiation token) is a hash of description and sources.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, suggest_name
from martensite.base.files import write_file
from martensite.export.c_names import choose_identifier
from martensite.export.fmu.binaries import TARGETS, build_library, checked_targets
from martensite.export.fmu.description import build_description, write_description
from martensite.export.fmu.plan import FmuPlan, plan_of, plan_port
from martensite.export.fmu.terminals import draw_icon, write_terminals
from martensite.export.fmu.variables import FmuVariable, list_variables
from martensite.export.fmu.wrapper import write_sources
from martensite.export.rates import require_rates
from martensite.scenario.scenario import Scenario

VERSIONS = ("2.0", "3.0")
_EPOCH = (1980, 1, 1, 0, 0, 0)
_GROUPS = ((0, 8), (8, 12), (12, 16), (16, 20), (20, 32))


@dataclass(frozen=True)
class Fmu:
    """An FMU that was written, and what is in it."""

    path: Path
    fmi: str
    name: str
    """The model identifier."""
    token: str
    """The GUID, or instantiation token."""
    step: float
    """The inner step [s]; the period of a system in discrete time."""
    discrete: bool
    variables: tuple[FmuVariable, ...]
    platforms: tuple[str, ...]
    """Machines for which it has a library; elsewhere its sources must be compiled."""

    @property
    def states(self) -> list[FmuVariable]:
        """Continuous states, of an FMU that is for model exchange too."""
        return [one for one in self.variables if one.nominal is not None]

    def named(self, causality: str) -> list[FmuVariable]:
        """Return the variables that are an input, output, parameter or local."""
        return [one for one in self.variables if one.causality == causality]


def to_fmu(
    model: Scenario | AbstractSystem,
    path: str | Path,
    *,
    fmi: str = "2.0",
    step: float | None = None,
    name: str | None = None,
    platforms: Sequence[str] | None = None,
    ports: bool = False,
    port: str | None = None,
    model_exchange: bool = False,
) -> Fmu:
    """Write a scenario, or a system, as an FMU; whatever is at the path is replaced.

    Args:
        model: a scenario; or a `System`, `Machine` or `Bench`.
        path: of the FMU.
        fmi: the version of FMI, 2.0 or 3.0.
        step: the longest step of the model within a step of the co-simulation [s]; by default
            that with which a run of the scenario reaches its tolerance, and for a system a tenth
            of its least thermal time constant. A system in discrete time has its period.
        name: the model identifier, an identifier of C; by default made of the name of the file.
        ports: the element alone: its elongation, drive and surroundings are inputs, its force and
            temperature outputs. What it pulls on is another model.
        port: where that element stands, if there are several.
        model_exchange: whether it must be for model exchange too; it is wherever it can be.
        platforms: for which to compile, such as `x86_64-linux`; by default all that the compiler
            of this machine and cross compilers of gcc are for; none for sources alone.

    Raises:
        InputError: an argument is out of range, or the version or compiler is missing; there is
            no model exchange of it.
        SolveError: the run that chooses the step failed.
        MartensiteError: the compiler failed.
    """
    path = Path(path)
    if fmi not in VERSIONS:
        raise InputError(f"No version of FMI named `{fmi}`. {suggest_name(fmi, VERSIONS)}")
    targets = checked_targets(platforms)
    called = choose_identifier(name, path.stem)
    if port is not None and not ports:
        raise InputError("Argument `port` chooses the element of an FMU with ports; add `ports`.")
    plan = plan_port(model, called, step, port) if ports else plan_of(model, called, step)
    if model_exchange:
        require_rates(plan.system)
    shown = list_variables(plan)
    token = _make_token([write_description(fmi, plan, shown, ""), *write_sources(plan, fmi, "").values()])
    texts = write_sources(plan, fmi, token)
    content: dict[str, str | bytes] = {"modelDescription.xml": write_description(fmi, plan, shown, token)}
    for target in targets:
        content[_locate_library(fmi, target, called)] = build_library(texts, target)
    content |= {f"sources/{file}": text for file, text in texts.items()}
    content |= _write_beside(fmi, plan)
    if ports and fmi == "3.0":
        folder = "terminalsAndIcons"
        content |= {f"{folder}/terminalsAndIcons.xml": write_terminals(shown), f"{folder}/icon.png": draw_icon()}
    write_file(path, _zip_files(content))
    discrete = plan.period > 0.0
    return Fmu(path, fmi, called, token, plan.step, discrete, shown, tuple(targets))


def _locate_library(fmi: str, target: str, name: str) -> str:
    known = TARGETS[target]
    return f"binaries/{known.folder if fmi == '2.0' else target}/{name}{known.ending}"


def _write_beside(fmi: str, plan: FmuPlan) -> dict[str, str]:
    found: dict[str, str] = {}
    if fmi == "3.0":
        found["sources/buildDescription.xml"] = build_description(plan.identifier, ["all.c"])
    if plan.scenario is not None:
        found["resources/scenario.toml"] = plan.scenario.text
    return found


def _make_token(texts: Sequence[str]) -> str:
    digest = hashlib.sha256("\0".join(texts).encode()).hexdigest()
    return "{" + "-".join(digest[a:b] for a, b in _GROUPS) + "}"


def _zip_files(files: Mapping[str, str | bytes]) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return whole.getvalue()
