"""Markdown about registered parts, materials, outputs, statuses and units."""

from __future__ import annotations

import inspect
import re
import shutil
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import martensite
from martensite.actuators.assembly import OUTPUTS
from martensite.base import units
from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.base.status import Status
from martensite.design.sweep.backends.base import BACKENDS
from martensite.design.sweep.sampling.samples import DESIGNS
from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS
from martensite.physics.materials.base import DOUBTFUL, NAMES, Material, load_material, material_names
from martensite.scenario import catalogue
from martensite.show.summaries.parts import write_default
from martensite.simulate.measures.base import MEASURES
from martensite.studies.base import VERDICTS, AbstractStudy, Answer, Claim, load_study, study_names
from martensite.studies.shipped_numbers import find_figure
from martensite.studies.tables import TableStudy

_SPACES = re.compile(r"[ \t\n]+")  # not those that keep words together
PLURALS = {
    "element": "Elements",
    "ends": "Ends of elements",
    "law": "Laws",
    "resistance": "Resistance models",
    "cooling": "Heat-loss models",
    "fluid": "Fluids",
    "mechanism": "Mechanisms",
    "drive": "Sources",
    "waveform": "Waveforms",
    "sensor": "Sensors",
    "observer": "Observers",
    "controller": "Controllers",
    "supervisor": "Supervisors",
    "check": "Checks of a supervisor",
    "fault": "Faults",
}

DIGEST_LABELS = {
    "holds": "Reproduced",
    "misprinted": "Misprints",
    "contradicts_itself": "Contradictions",
    "assumed": "Assumptions",
    "use_instead": "Recommended values",
}


def table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(_cell(c) for c in line) + " |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return " ".join(_SPACES.split(text.strip())).replace("|", r"\|")


def plain(text: str) -> str:
    """Text in which stars and angles mean themselves."""
    return text.replace("*", r"\*").replace("<", r"\<")


def code(text: str) -> str:
    """Inline code, or nothing for nothing."""
    return f"`{text}`" if text else ""


def cited(key: str) -> str:
    """A link to an entry of the bibliography."""
    return f"[{key}](#bib-{key})"


# -- registered parts --------------------------------------------------------------------
def all_parts() -> str:
    """One section per registry, one below it per entry."""
    return "\n".join(
        f"## {PLURALS.get(kind, kind)}\n\n"
        + "\n".join(part(catalogue.describe_class(kind, registry[name])) for name in registry.names())
        for kind, registry in catalogue.list_registries().items()
    )


def part(found: catalogue.PartDescription) -> str:
    """Description, parameters and sources of one registered part."""
    sources = ", ".join(cited(key) for key in found["cites"])
    return "\n".join(
        [
            f"(part-{found['kind']}-{found['name']})=",
            f"### `{found['name']}`\n",
            f"{found['summary']}\n",
            f"{found['description']}\n",
            _parameters(found["parameters"]),
            f"Sources: {sources}.\n" if sources else "",
        ]
    )


def _parameters(declared: Sequence[catalogue.EntryDescription]) -> str:
    if not declared:
        return "No parameters.\n"
    columns = ("parameter", "unit", "meaning", "allowed", "default")
    return table(columns, [_parameter(entry) for entry in declared])


def parameters_of(cls: type[Parametrised]) -> str:
    """The parameters of a class that is in no registry."""
    return _parameters(catalogue.describe_class("", cls)["parameters"])


TOP = "martensite"


@cache
def list_api() -> dict[str, list[str]]:
    """Return the public names of every namespace, `martensite` first."""
    inner = [name for name in dir(martensite) if isinstance(getattr(martensite, name), ModuleType)]
    names = {TOP: [name for name in dir(martensite) if name not in inner]}
    for name in inner:
        package = getattr(martensite, name)
        offered = getattr(package, "__all__", None) or dir(package)
        names[name] = [one for one in dir(package) if not one.startswith("_") and one in offered]
    return names


def api_page(namespace: str) -> str:
    """Return a table and the full descriptions of the names of a namespace."""
    home = TOP if namespace == TOP else getattr(martensite, namespace).__name__
    package = import_module(home)
    found = {name: getattr(package, name) for name in list_api()[namespace]}
    rows = [(_refer_to(home, name, one), _kind_of(one), plain(_first_sentence(one))) for name, one in found.items()]
    lines = [line for name, one in found.items() for line in _directive(home, name, one)]
    return table(("name", "kind", "summary"), rows) + "\n```{eval-rst}\n" + "\n".join(lines) + "\n```\n"


def _first_home(found: Any, name: str) -> str:
    """Return the first namespace that offers a class."""
    for namespace, names in list_api().items():
        package = martensite if namespace == TOP else getattr(martensite, namespace)
        if name in names and getattr(package, name) is found:
            return package.__name__
    raise LookupError(name)


def _refer_to(home: str, name: str, found: Any) -> str:
    owner = _first_home(found, name) if inspect.isclass(found) else home
    return f"{{py:obj}}`{name} <{owner}.{name}>`"


def _kind_of(found: Any) -> str:
    if inspect.isclass(found):
        return "exception" if issubclass(found, BaseException) else "class"
    return "function" if inspect.isfunction(found) else "data"


def _first_sentence(found: Any) -> str:
    if _kind_of(found) == "data":
        return f"Registry of parts of kind `{found.kind}`." if isinstance(found, Registry) else type(found).__name__
    paragraph = " ".join((inspect.getdoc(found) or "").partition("\n\n")[0].split())
    return re.split(r"(?<=[.:])\s", paragraph, maxsplit=1)[0].rstrip(":")


def _directive(home: str, name: str, found: Any) -> list[str]:
    """Return the directive for a name; a class is indexed in its first namespace only."""
    if not inspect.isclass(found):
        function = inspect.isfunction(found)
        return [f".. autofunction:: {home}.{name}"] if function else [f".. py:data:: {home}.{name}", ""]
    lines = [f".. autoclass:: {home}.{name}"]
    if _first_home(found, name) != home:
        lines.append("   :no-index:")
    if not issubclass(found, Parametrised | BaseException | tuple):
        lines.append("   :members:")
    return lines


def _parameter(entry: catalogue.EntryDescription) -> tuple[str, ...]:
    unit, default = entry["unit"] or "", plain(write_default(entry))
    words = [code(word.strip()) for word in entry["allowed"].split("|")]
    allowed = plain(entry["allowed"]) if entry["unit"] else " ".join(words)
    shown = "" if unit == "1" else code(unit)
    return code(entry["name"]), shown, plain(entry["meaning"]), allowed, default


# -- materials ---------------------------------------------------------------------------
def all_materials() -> str:
    """One section per material."""
    return "\n".join(material(load_material(name)) for name in material_names())


def material(found: Material) -> str:
    """Every number of a material with its kind and source."""
    rows = [
        (
            code(name),
            plain(number.text),
            f"**{number.kind}**" if number.kind in DOUBTFUL else number.kind,
            ", ".join(filter(None, (cited(found.sources[number.source].cite), number.where))),
            plain(number.note),
        )
        for name, number in found.values.items()
    ]
    return "\n".join(
        [
            f"(material-{found.name})=",
            f"## `{found.name}`\n",
            f"{found.title}. {found.summary}\n",
            f"*Limits.* {found.limits}\n",
            *_of_law(found),
            table(("number", "value", "kind", "source", "note"), rows),
        ]
    )


def _of_law(found: Material) -> Iterator[str]:
    """The law that the numbers hold for."""
    if found.law is not None:
        options = [code(f"{name} = {word}") for name, word in found.law.items() if name != "kind"]
        more = f" with {', '.join(options)}" if options else ""
        words = "taken by a scenario that names none"
        yield f"*Law.* {code(found.law['kind'])}{more}; {words}.\n"


def canonical_numbers() -> str:
    """The names under which materials hold numbers."""
    rows = [(code(name), code(unit), meaning) for name, (unit, meaning) in NAMES.items()]
    return table(("name", "SI unit", "meaning"), rows)


# -- sweeps ------------------------------------------------------------------------------
def sweeps() -> str:
    """Return the measures with their parameters, then sampling methods, back ends and kinds of experiments."""
    measures = [part(catalogue.describe_class("measure", MEASURES[name])) for name in MEASURES.names()]
    others = {"Samples": DESIGNS, "Back ends": BACKENDS, "Kinds of experiments": EXPERIMENT_KINDS}
    listed = [f"## {title}\n\n{_listed(registry)}" for title, registry in others.items()]
    return "\n".join(["## Measures\n", *measures, *listed])


def _listed(registry: Registry[Any]) -> str:
    rows = [(code(name), catalogue.summarise_class(registry[name])) for name in registry.names()]
    return table((registry.kind, "description"), rows)


# -- results -----------------------------------------------------------------------------
def outputs() -> str:
    """The columns of every result."""
    rows = [
        (code(name), symbol, "that of the source" if name == "drive" else code(unit), long_name)
        for name, (unit, long_name, symbol) in OUTPUTS.items()
    ]
    own = "coordinates of the mechanism, rates where inertia counts, and its own signals"
    rows.append(("`position`, `angle`, …", "", "of the mechanism", own))
    return table(("column", "symbol", "SI unit", "meaning"), rows)


def statuses() -> str:
    """How a step can end."""
    rows = [(code(status.name), "yes" if status.failed else "no", status.sentence) for status in Status]
    return table(("status", "failed", "what it means and what to try"), rows)


def everyday_units() -> str:
    """Spellings of units that are read without pint."""
    kinds: dict[str, list[str]] = {}
    for spelling, (unit, _, _) in units.EVERYDAY.items():
        kinds.setdefault(unit, []).append(spelling)
    rows = [
        (
            "none" if unit == "1" else code(unit),
            " ".join(code(s) for s in spellings),
            "" if units.choose_readable_unit(unit) == unit else code(units.choose_readable_unit(unit)),
        )
        for unit, spellings in kinds.items()
    ]
    return table(("SI unit", "accepted spellings", "shown as"), rows)


# -- studies -----------------------------------------------------------------------------
FIGURES = Path(__file__).parents[1] / "_figures"
"""Where figures of studies are drawn."""


@cache
def figure(name: str) -> str:
    """The figure of a study, drawn once in a build; one that takes minutes is that which the study came with."""
    found = load_study(name)
    FIGURES.mkdir(exist_ok=True)
    shipped = find_figure(found) if isinstance(found, TableStudy) else None
    if shipped is None:
        found.figure(FIGURES / f"{name}.svg")
    else:
        shutil.copyfile(shipped, FIGURES / f"{name}.svg")
    return f"![{found.title}](_figures/{name}.svg)"


STUDY_PAGES = {
    "migaone": "migaone",
    "hammerstein-wiener": "hammerstein-wiener",
    "platform": "platform",
    "wire-heating": "sommerfeld",
    "sommerfeld": "sommerfeld",
    "finger": "finger",
    "finger-calibration": "finger",
}
"""Studies whose claims are on a page about their source."""


def all_studies() -> str:
    """Return counts, claims and reports of all studies."""
    studies = [load_study(name) for name in study_names()]
    answers = {study: study.find_answer() for study in studies}
    return "\n".join([_tally(answers), *(_study(study, answer) for study, answer in answers.items())])


def digest(name: str) -> str:
    """Return the digest of a study as a table."""
    answer = load_study(name).find_answer()
    return table(("", "result"), ((DIGEST_LABELS[key], plain(text)) for key, text in answer.digest.items())) + "\n"


def _tally(answers: Mapping[AbstractStudy, Answer]) -> str:
    """How many claims of each verdict every source has, and how many reports."""
    counts: dict[str, Counter[str]] = {}
    for study, answer in answers.items():
        counts.setdefault(study.cites[0], Counter()).update(answer.count_all())
    columns = (*VERDICTS, "reports")
    rows = [(cited(source), *(str(found[name]) for name in columns)) for source, found in counts.items()]
    return table(("source", *map(unbroken, columns)), rows) + "\n"


def _study(found: AbstractStudy, answer: Answer) -> str:
    page = STUDY_PAGES.get(found.key)
    told = f"Claims and verdicts: [page of this source](sources/{page}.md#claims-and-verdicts).\n" if page else None
    reports = [(plain(one.statement), _number(one.computed), one.unit, plain(one.why)) for one in answer.reports]
    return "\n".join(
        [
            f"### `{found.key}`\n",
            f"{found.title}. Source: {', '.join(cited(key) for key in found.cites[:1])}.\n",
            told or _claims_of(found, answer),
            "\n<details><summary>Computed numbers without a printed counterpart</summary>\n",
            table(("quantity", "computed", "unit", "comment"), reports),
            "</details>\n",
        ]
    )


def _claims_of(found: AbstractStudy, answer: Answer) -> str:
    columns = ("claim", "published", "computed", "unit", "verdict", "reason")
    return digest(found.key) + "\n" + table(columns, map(_claim, answer.claims))


def _claim(claim: Claim) -> tuple[str, ...]:
    printed = _number(claim.published) if claim.as_printed is None else f"({_number(claim.as_printed)})"
    if claim.tolerance is not None:
        printed += f" ± {claim.tolerance:.2g}"
    why = plain(claim.describe_reason())
    return plain(claim.statement), printed, _number(claim.computed), claim.unit, unbroken(claim.verdict), why


def _number(number: float | None) -> str:
    return "" if number is None else f"{number:.4g}"


def unbroken(words: str) -> str:
    """Words that stay in one line."""
    return words.replace(" ", "\N{NO-BREAK SPACE}")
