"""`martensite app --static DIR`: the bench as a folder."""

from __future__ import annotations

from gzip import compress
from pathlib import Path

import typer

from martensite.base.errors import InputError
from martensite.scenario.scenario import load
from martensite.show.terminal import print_json
from martensite_app.documents import check_files
from martensite_app.static_site.site_writer import can_offer, list_offered, prepare_folder, write_site


def write_page(folder: Path, scenario: Path | None, json: bool) -> None:
    """Write the bench with the scenarios of the package, or with one of a file alone.

    Raises:
        InputError: the page cannot run that scenario, or there is no compiler of WebAssembly.
        DataError: the folder holds something else, or the scenario names files.
    """
    prepare_folder(folder)
    texts = list_offered() if scenario is None else {scenario.stem: load(scenario).text}
    for name, text in texts.items():
        check_files(text, {})
        if not can_offer(text):
            raise InputError(
                f"A page without a server cannot run `{name}`: it starts elsewhere than at home, or keeps states. "
                "Use `martensite app`."
            )
    manifest = write_site(folder, texts, lambda words: typer.echo(words, err=True))
    made = sorted(path for path in folder.rglob("*") if path.is_file())
    sizes = [path.stat().st_size for path in made]
    packed = sum(len(compress(path.read_bytes(), 9)) for path in made)
    if json:
        names = [one["name"] for one in manifest["scenarios"]]
        print_json(
            {"folder": str(folder), "files": len(made), "bytes": sum(sizes), "compressed": packed, "scenarios": names}
        )
        return
    typer.echo(f"{folder}: {len(made)} files, {sum(sizes) / 1e6:.1f} MB, {packed / 1e6:.1f} MB compressed")
    typer.echo(f"See it with: python -m http.server --directory {folder}")
