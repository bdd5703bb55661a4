"""Sources of an FMU: the core, the interface of FMI, and the table that connects them.

The interface needs no headers of the standard. `all.c` includes all other sources.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib.resources import files

from martensite.export.fmu.plan import FmuPlan, ModelNumber
from martensite.export.fmu.variables import KIND
from martensite.simulate.grid import place_signal

SHARED = ("instance.c", "values.c", "steps.c", "states.c")
"""Sources of both versions of FMI; each includes the previous one."""
MOST_STEPS = 1e9
"""Largest number of inner steps in a step of the co-simulation."""
_LARGEST = 1.7e308


def write_sources(plan: FmuPlan, version: str, token: str) -> dict[str, str]:
    """Return all C of an FMU by file name; `token` is its GUID or instantiation token."""
    interface = f"fmi{version[0]}.c"
    included = (f"{plan.core.name}.c", "model.h", interface)
    texts = {"all.c": "".join(f'#include "{name}"\n' for name in included), **plan.core.files}
    texts["model.h"] = _write_model(plan, token)
    folder = files("martensite.export.fmu")
    for name in (*SHARED, interface):
        texts[name] = (folder / name).read_text(encoding="utf-8")
    return texts


def _write_model(plan: FmuPlan, token: str) -> str:
    core = plan.core.name
    numbers = {
        "FMU_TOKEN": f'"{token}"',
        "FMU_TOKEN_SIZE": len(token) + 1,
        "FMU_KIND": KIND,
        "FMU_STEP": repr(plan.step),
        "FMU_PERIOD": repr(float(plan.period)),
        "FMU_OWN": 0 if plan.period else 1,
        "FMU_MOST_STEPS": repr(MOST_STEPS),
        "FMU_INPUTS": f"{core}_INPUTS",
        "FMU_OUTPUTS": f"{core}_OUTPUTS",
        "FMU_NUMBERS": len(plan.numbers),
        "CORE_STATES": f"{core}_STATES",
        "CORE_MODEL": f"{core}_model",
        "CORE(f)": f"{core}_##f",
        "CORE_STATUS(s)": f"{core}_##s",
    }
    numbers |= _locate_moved(plan)
    defined = "".join(f"#define {key} {value}\n" for key, value in numbers.items())
    rules = ",\n    ".join(_write_rule(number) for number in plan.numbers)
    at_end = [place_signal(drive.at_end) for drive in plan.system.drives()]
    return (
        f"{defined}\n{_RULE}static const rule rules[] = {{\n    {rules}\n}};\n"
        f"static const double first_inputs[] = {{{_format_numbers(plan.first)}}};\n"
        "/* Where in an inner step an input is read. */\n"
        f"static const double sampled_at[] = {{{_format_numbers(at_end)}}};\n"
    )


def _locate_moved(plan: FmuPlan) -> dict[str, object]:
    places = {one.name: one.index for one in plan.core.inputs}
    if "velocity" not in places:
        return {}
    return {"FMU_MOVED": places["elongation"], "FMU_VELOCITY": places["velocity"]}


_RULE = """\
enum { FREE, CONSTANT, HIDDEN };

/* A number of the system: its place in the core, and what is allowed; open: low itself is not. */
typedef struct {
    const char *name;
    int kind, place, open;
    double low, high;
} rule;

"""


def _write_rule(number: ModelNumber) -> str:
    declared = number.leaf.declared
    low, high = (max(-_LARGEST, min(_LARGEST, bound)) for bound in declared.bounds)
    is_open = int(declared.open_low)
    return f'{{"{number.name}", {number.kind}, {number.place}, {is_open}, {low!r}, {high!r}}}'


def _format_numbers(values: Iterable[float]) -> str:
    return ", ".join([repr(float(value)) for value in values] or ["0.0"])
