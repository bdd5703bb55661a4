"""`cite`: BibTeX for exactly what a scenario or a study rests on."""

from __future__ import annotations

from typing import Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, Settings, import_modules


@app.command()
def cite(
    name: Annotated[
        str, typer.Argument(metavar="SCENARIO|STUDY", help="A scenario file, or a study's name.")
    ],
    settings: Settings = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Print BibTeX of what a scenario or a study rests on."""
    import_modules(modules)
    from martensite.cli import show
    from martensite.scenario import citations

    keys = _of_scenario(name, settings) if name.endswith(".toml") else _of_study(name)
    texts = citations.list_entries(keys)
    if json:
        show.as_json([{"key": k, "bibtex": t} for k, t in zip(keys, texts, strict=True)])
    else:
        typer.echo("\n\n".join(texts))


def _of_scenario(name: str, settings: list[str] | None) -> list[str]:
    from martensite.scenario.citations import list_citations
    from martensite.scenario.overrides import read_settings
    from martensite.scenario.scenario import load

    scenario = load(name, read_settings(settings or []))
    return list_citations(scenario, scenario.material)


def _of_study(name: str) -> list[str]:
    from martensite.studies.base import load_study

    return list(dict.fromkeys(load_study(name).cites))
