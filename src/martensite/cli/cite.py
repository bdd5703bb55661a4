"""`cite`: BibTeX for exactly what a scenario or a study rests on."""

from __future__ import annotations

from typing import Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import Imports, Json, Settings, import_modules, load_scenario


@app.command()
def cite(
    name: Annotated[str, typer.Argument(metavar="SCENARIO|STUDY", help="A scenario file, or a study's name.")],
    settings: Settings = None,
    json: Json = False,
    modules: Imports = None,
) -> None:
    """Print BibTeX of what a scenario or a study rests on."""
    import_modules(modules)
    from martensite.scenario import citations
    from martensite.show.terminal import print_json

    if name.endswith(".toml"):
        loaded = load_scenario(name, settings)
        keys = citations.list_citations(loaded, loaded.material)
    else:
        from martensite.studies.base import load_study

        keys = list(dict.fromkeys(load_study(name).cites))
    texts = citations.list_entries(keys)
    if json:
        print_json([{"key": k, "bibtex": t} for k, t in zip(keys, texts, strict=True)])
    else:
        typer.echo("\n\n".join(texts))
