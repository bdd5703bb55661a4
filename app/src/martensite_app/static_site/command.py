"""`martensite app --static DIR`: the bench as a folder."""

from __future__ import annotations

from pathlib import Path

import typer

from martensite.base.errors import InputError
from martensite.scenario.scenario import load
from martensite.show.terminal import print_json
from martensite_app.documents import check_files
from martensite_app.static_site.site_writer import can_offer, check_folder, list_offered, measure_folder, write_site


def write_page(folder: Path, scenario: Path | None, json: bool) -> None:
    """Write the bench with the scenarios of the package, or with one of a file alone.

    Raises:
        InputError: the page cannot run that scenario, or there is no compiler of WebAssembly.
        DataError: the folder holds something else, or the scenario names files.
    """
    check_folder(folder)
    texts = list_offered() if scenario is None else {scenario.stem: load(scenario).text}
    for name, text in texts.items():
        check_files(text, {})
        if not can_offer(text):
            raise InputError(
                f"A page without a server cannot run `{name}`: it starts elsewhere than at home, or keeps states. "
                "Use `martensite app`."
            )
    manifest = write_site(folder, texts, lambda words: typer.echo(words, err=True))
    made = measure_folder(folder)
    if json:
        names = [one["name"] for one in manifest["scenarios"]]
        sizes = {"files": made.files, "bytes": made.size, "compressed": made.compressed}
        print_json({"folder": str(folder), **sizes, "scenarios": names})
        return
    typer.echo(f"{folder}: {made.words()}")
    typer.echo(f"See it with: python -m http.server --directory {folder}")
