"""modelDescription.xml of FMI 2.0 and 3.0, and buildDescription.xml of 3.0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib.metadata import version
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from martensite.export.fmu.plan import FmuPlan
from martensite.export.fmu.variables import TIME, FmuVariable, add_units

CATEGORIES = ("logStatusWarning", "logStatusDiscard", "logStatusError")


def write_description(fmi: str, plan: FmuPlan, variables: Sequence[FmuVariable], token: str) -> str:
    """Return modelDescription.xml for FMI 2.0 or 3.0."""
    root = _write_version_2(plan, variables, token) if fmi == "2.0" else _write_version_3(plan, variables, token)
    return as_text(root)


def build_description(identifier: str, sources: Sequence[str]) -> str:
    """Return buildDescription.xml of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(configuration, "Library", name="m")
    return as_text(root)


def as_text(root: Element) -> str:
    """Return an element as an XML document."""
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _write_version_2(plan: FmuPlan, variables: Sequence[FmuVariable], token: str) -> Element:
    root = Element("fmiModelDescription", fmiVersion="2.0", modelName=plan.title, guid=token)
    root.attrib |= {"description": plan.system.description(), "generationTool": _name_tool()}
    slave = SubElement(root, "CoSimulation", modelIdentifier=plan.identifier)
    slave.attrib |= {
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false" if plan.period else "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    SubElement(SubElement(slave, "SourceFiles"), "File", name="all.c")
    _write_head(root, plan, variables)
    rows = SubElement(root, "ModelVariables")
    for one in variables:
        scalar = SubElement(rows, "ScalarVariable", _name_variable(one))
        SubElement(scalar, "Real", _type_variable(one))
    parts = SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(parts, name)
        for index, one in enumerate(variables, 1):
            if one.causality == "output":
                SubElement(unknowns, "Unknown", index=str(index))
    return root


def _write_version_3(plan: FmuPlan, variables: Sequence[FmuVariable], token: str) -> Element:
    root = Element("fmiModelDescription", fmiVersion="3.0", modelName=plan.title)
    root.attrib |= {
        "instantiationToken": token,
        "description": plan.system.description(),
        "generationTool": _name_tool(),
    }
    simulated = SubElement(root, "CoSimulation", modelIdentifier=plan.identifier)
    simulated.attrib |= {
        "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
    }
    _write_head(root, plan, variables)
    rows = SubElement(root, "ModelVariables")
    time = {"name": _time_name(variables), "valueReference": str(TIME)}
    SubElement(rows, "Float64", time, causality="independent", variability="continuous", unit="s")
    for one in variables:
        SubElement(rows, "Float64", _name_variable(one) | _type_variable(one))
    parts = SubElement(root, "ModelStructure")
    for name in ("Output", "InitialUnknown"):
        for one in variables:
            if one.causality == "output":
                SubElement(parts, name, valueReference=str(one.reference))
    return root


def _write_head(root: Element, plan: FmuPlan, variables: Sequence[FmuVariable]) -> None:
    """Write units, log categories and default experiment, which both versions share."""
    used = {one.unit: None for one in variables if one.unit is not None}
    add_units(root, list({**used, "s": None}))
    logged = SubElement(root, "LogCategories")
    for name in CATEGORIES:
        SubElement(logged, "Category", name=name)
    SubElement(root, "DefaultExperiment", _write_experiment(plan))


def _write_experiment(plan: FmuPlan) -> dict[str, str]:
    attributes, scenario = {"startTime": "0.0"}, plan.scenario
    interval = plan.period
    if scenario is not None:
        attributes["stopTime"] = repr(scenario.duration)
        interval = interval or scenario.duration / (scenario.samples - 1)
    return attributes | ({"stepSize": repr(interval)} if interval else {})


def _name_variable(one: FmuVariable) -> dict[str, str]:
    initial = {"output": "calculated", "parameter": "exact", "local": "exact"}.get(one.causality)
    return {
        "name": one.name,
        "valueReference": str(one.reference),
        "description": one.words,
        "causality": one.causality,
        "variability": one.variability,
        **({} if initial is None else {"initial": initial}),
    }


def _type_variable(one: FmuVariable) -> dict[str, str]:
    attributes: dict[str, str] = {}
    if one.unit is not None:
        attributes["unit"] = one.unit
    if one.display is not None:
        attributes["displayUnit"] = one.display
    numbers = ("min", one.low), ("max", one.high), ("start", one.start)
    for name, value in numbers:
        if value is not None and math.isfinite(value):
            attributes[name] = repr(float(value))
    return attributes


def _time_name(variables: Sequence[FmuVariable]) -> str:
    return "simulation_time" if any(one.name == "time" for one in variables) else "time"


def _name_tool() -> str:
    return f"martensite {version('martensite')}"
