"""`to_fmu`: a scenario or a system as an FMU of FMI 2.0 or 3.0.

An FMU supports co-simulation. The same scenario gives the same archive: times in it are fixed, and its GUID
(instantiation token) is a hash of description and sources.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, require_known
from martensite.base.files import write_file
from martensite.export.c_names import choose_identifier
from martensite.export.fmu.binaries import TARGETS, build_library, checked_targets
from martensite.export.fmu.description import build_description, write_description
from martensite.export.fmu.plan import FmuPlan, plan_of, plan_port
from martensite.export.fmu.terminals import draw_icon, write_terminals
from martensite.export.fmu.variables import FmuVariable, list_variables
from martensite.export.fmu.wrapper import write_sources
from martensite.scenario.scenario import Scenario

VERSIONS = ("2.0", "3.0")
_EPOCH = (1980, 1, 1, 0, 0, 0)
_GROUPS = ((0, 8), (8, 12), (12, 16), (16, 20), (20, 32))


@dataclass(frozen=True)
class Fmu:
    """A written FMU."""

    path: Path
    fmi: str
    name: str
    """Model identifier."""
    token: str
    """GUID, or instantiation token."""
    step: float
    """Inner step [s], or the period in discrete time."""
    discrete: bool
    variables: tuple[FmuVariable, ...]
    platforms: tuple[str, ...]
    """Targets with a library; elsewhere the sources must be compiled."""

    def select_variables(self, causality: str) -> list[FmuVariable]:
        """Return the variables of a causality: input, output, parameter or local."""
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
) -> Fmu:
    """Write a scenario or a system as an FMU. An existing file is replaced.

    Args:
        model: a scenario; or a `System`, `Machine` or `Bench`.
        path: path of the FMU.
        fmi: version of FMI, 2.0 or 3.0.
        step: longest inner step [s]; by default the step with which a run of the scenario reaches its tolerance, or a
            tenth of the shortest thermal time constant of a system. Not for discrete time.
        name: model identifier, a C identifier; by default made of the file name.
        ports: whether to export the element alone. Inputs are its elongation, drive and ambient temperature; outputs
            its force and temperature.
        port: port of that element, if there are several.
        platforms: targets such as `x86_64-linux`; by default all of this machine's compiler and cross compilers of gcc.
            Empty for sources alone.

    Raises:
        InputError: an argument is out of range, or the version or compiler is missing.
        SolveError: the run that chooses the step failed.
        MartensiteError: the compiler failed.
    """
    path = Path(path)
    require_known("version of FMI", fmi, VERSIONS)
    targets = checked_targets(platforms)
    identifier = choose_identifier(name, path.stem)
    if port is not None and not ports:
        raise InputError("Argument `port` chooses the element of an FMU with ports; add `ports`.")
    plan = plan_port(model, identifier, step, port) if ports else plan_of(model, identifier, step)
    variables = list_variables(plan)
    token = _make_token([write_description(fmi, plan, variables, ""), *write_sources(plan, fmi, "").values()])
    texts = write_sources(plan, fmi, token)
    content: dict[str, str | bytes] = {"modelDescription.xml": write_description(fmi, plan, variables, token)}
    for target in targets:
        content[_locate_library(fmi, target, identifier)] = build_library(texts, target)
    content |= {f"sources/{file}": text for file, text in texts.items()}
    content |= _write_beside(fmi, plan)
    if ports and fmi == "3.0":
        folder = "terminalsAndIcons"
        content |= {f"{folder}/terminalsAndIcons.xml": write_terminals(variables), f"{folder}/icon.png": draw_icon()}
    write_file(path, _zip_files(content))
    discrete = plan.period > 0.0
    return Fmu(path, fmi, identifier, token, plan.step, discrete, variables, tuple(targets))


def _locate_library(fmi: str, target: str, name: str) -> str:
    properties = TARGETS[target]
    return f"binaries/{properties.folder if fmi == '2.0' else target}/{name}{properties.ending}"


def _write_beside(fmi: str, plan: FmuPlan) -> dict[str, str]:
    files: dict[str, str] = {}
    if fmi == "3.0":
        files["sources/buildDescription.xml"] = build_description(plan.identifier, ["all.c"])
    if plan.scenario is not None:
        files["resources/scenario.toml"] = plan.scenario.text
    return files


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
