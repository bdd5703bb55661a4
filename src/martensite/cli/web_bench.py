"""`app`: the web bench in the browser.

The state of the bench is in its address: the text of a scenario, deflated, behind the `#`, which stays in the browser.
"""

from __future__ import annotations

import base64
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from martensite.base.lazy import import_extra
from martensite.cli.app import app
from martensite.cli.options import Json

if TYPE_CHECKING:
    from collections.abc import Callable

    from martensite_app.server import Served


@app.command("app")
def bench_app(
    scenario: Annotated[
        Path | None, typer.Argument(metavar="[SCENARIO]", help="A scenario file to begin with.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on this machine; 0 for the last one, or a free one.")] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
    folder: Annotated[
        Path | None, typer.Option(help="Where files are kept, made if need be [default: one that ends with it].")
    ] = None,
    static: Annotated[Path | None, typer.Option(help="Write it as a folder for any file server, and end.")] = None,
    json: Json = False,
) -> None:
    """Open the web bench: sliders, loops, motion, your own logs.

    It is reachable from this machine alone, and only with the token in the address. Ctrl-C ends it.
    """
    served = import_extra("martensite_app.server", "app", "the web bench")
    if static is not None:
        return import_extra("martensite_app.static_site.command", "app,export,cc").write_page(static, scenario, json)
    text = None if scenario is None else _read_text(scenario)
    served.serve_bench(port, folder, _make_opener(text, no_browser, json))


def _read_text(scenario: Path) -> str:
    from martensite.scenario.scenario import load

    return load(scenario).text


def _make_opener(text: str | None, no_browser: bool, json: bool) -> Callable[[Served], None]:
    def ready(at: Served) -> None:
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
    """A text as letters that may stand in an address."""
    made = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = made.compress(text.encode()) + made.flush()
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def build_address(address: str, text: str) -> str:
    """The address of a bench that begins with a scenario."""
    return f"{address}#/bench?scenario={pack_text(text)}"
