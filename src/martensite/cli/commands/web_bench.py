"""`app`: the web bench.

The address holds the state of the bench: the compressed text of a scenario after the `#`, which stays in the browser.
"""

from __future__ import annotations

import base64
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from martensite.base.errors import InputError
from martensite.cli.app import app
from martensite.cli.options import Json

if TYPE_CHECKING:
    from collections.abc import Callable

    from martensite.app.server import ServerAddress


@app.command("app", rich_help_panel="Take along")
def bench_app(
    scenario: Annotated[Path | None, typer.Argument(metavar="[SCENARIO]", help="Scenario file to open first.")] = None,
    port: Annotated[int, typer.Option(help="Network port, 0 for the last port or a free port.")] = 0,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Print the address without opening a browser.")
    ] = False,
    folder: Annotated[
        Path | None, typer.Option(help="Project folder, made if it is missing [default: a temporary folder].")
    ] = None,
    static: Annotated[Path | None, typer.Option(help="Folder to write the page into, for any file server.")] = None,
    json: Json = False,
) -> None:
    """Open the web bench in the browser.

    Only this machine can reach the page, and only with the token in the address. Ctrl-C ends the server.
    """
    from martensite.app.server import serve_bench

    if static is not None:
        return _write_page(static, scenario, json)
    text = None if scenario is None else _read_text(scenario)
    serve_bench(port, folder, _make_opener(text, no_browser, json))


def _read_text(scenario: Path) -> str:
    from martensite.scenario.scenario import load

    return load(scenario).text


def _make_opener(text: str | None, no_browser: bool, json: bool) -> Callable[[ServerAddress], None]:
    def ready(at: ServerAddress) -> None:
        address = at.address if text is None else build_address(at.address, text)
        if json:
            from martensite.show.terminal import print_json

            print_json({"address": address, "port": at.port, "token": at.token})
        else:
            typer.echo(f"martensite app: {address}")
            typer.echo("Ctrl-C ends it.")
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    return ready


def pack_text(text: str) -> str:
    """Return a text encoded for an address."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = packer.compress(text.encode()) + packer.flush()
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def build_address(address: str, text: str) -> str:
    """Return the address of a bench that opens a scenario."""
    return f"{address}#/bench?scenario={pack_text(text)}"


def _write_page(folder: Path, scenario: Path | None, json: bool) -> None:
    """Write the static bench with the packaged scenarios or one given scenario."""
    from martensite.app.documents import check_files
    from martensite.app.static_site.site_writer import can_offer, check_folder, list_offered, measure_folder, write_site
    from martensite.scenario.scenario import load
    from martensite.show.terminal import print_json

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
    folder_size = measure_folder(folder)
    if json:
        names = [one["name"] for one in manifest["scenarios"]]
        sizes = {"files": folder_size.files, "bytes": folder_size.size, "compressed": folder_size.compressed}
        print_json({"folder": str(folder), **sizes, "scenarios": names})
        return
    typer.echo(f"{folder}: {folder_size.words()}")
    typer.echo(f"See it with: python -m http.server --directory {folder}")
