"""`app`: the web bench in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from martensite.base.errors import DataError
from martensite.cli.app import app
from martensite.cli.options import Json

if TYPE_CHECKING:
    from collections.abc import Callable

    from martensite.app.server import Served


@app.command("app")
def bench_app(
    scenario: Annotated[
        Path | None, typer.Argument(metavar="[SCENARIO]", help="A scenario file to begin with.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on this machine; 0 for a free one.")] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
    folder: Annotated[
        Path | None, typer.Option(help="Where files are kept [default: a folder that ends with the bench].")
    ] = None,
    json: Json = False,
) -> None:
    """Open the web bench: sliders, loops, motion, your own logs.

    It is reachable from this machine alone, and only with the token in the address. Ctrl-C ends it.
    """
    from martensite.app.server import serve_bench

    text = None if scenario is None else _read_text(scenario)
    if folder is not None and not folder.is_dir():
        raise DataError(f"There is no folder `{folder}`; create it first.")
    serve_bench(port, folder, _make_opener(text, no_browser, json))


def _read_text(scenario: Path) -> str:
    """The text of a scenario that can be built."""
    from martensite.scenario.scenario import load

    return load(scenario).text


def _make_opener(text: str | None, no_browser: bool, json: bool) -> Callable[[Served], None]:
    """What says where the bench is, and opens it."""

    def ready(at: Served) -> None:
        from martensite.app.address import build_address

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
