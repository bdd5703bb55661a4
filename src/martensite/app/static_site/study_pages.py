"""Studies of a static page: their data, and one plain page with a citable address for each."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from martensite.app.calls.studies import describe_study_page, list_studies
from martensite.app.messages import JsonTable, write_message
from martensite.app.worker import Desk
from martensite.studies.base import load_study

PAGES = "studies"
"""Folder of the pages in that of the bench."""
STYLE = """
:root { color-scheme: light dark }
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif }
img { width: 100%; height: auto; background: #fff }
div { overflow-x: auto }
table { border-collapse: collapse; width: 100% }
th, td { padding: .3rem .6rem; border-bottom: 1px solid #8886; text-align: left; vertical-align: top; font-weight: 400 }
thead th, .misprint td:last-child { font-weight: 600 }
td.number { text-align: right; white-space: nowrap }
"""
HEADINGS = ("Claim", "Printed", "Computed", "Unit", "Verdict")


def write_studies(folder: Path, runs: Path) -> None:
    """Write the installed studies with their shipped results and figures.

    Args:
        folder: folder of the bench; each study gets `studies/NAME.html` there, and `studies/NAME.svg` for its figure.
        runs: folder of the data that the bench reads.
    """
    desk = Desk(folder)
    listed = [one | {"missing": []} for one in list_studies({}, desk)["studies"]]
    (runs / "studies.json").write_bytes(write_message({"studies": listed}))
    (folder / PAGES).mkdir(exist_ok=True)
    for name in (one["name"] for one in listed):
        page = describe_study_page({"name": name}, desk) | {"missing": []}
        (runs / f"study-{name}.json").write_bytes(write_message(page))
        if (figure := load_study(name).shipped_figure()) is not None:
            shutil.copyfile(figure, folder / PAGES / f"{name}.svg")
        (folder / PAGES / f"{name}.html").write_text(render_page(page, figure is not None), encoding="utf-8")


def render_page(page: JsonTable, has_figure: bool) -> str:
    """Return a study as HTML without scripts: figure, digest, printed and computed values, sources."""
    name, title, results = page["name"], escape(page["title"]), page["results"] or {}
    about = escape(page["guide"][0]) if page["guide"] else title
    image = f'<img src="{name}.svg" alt="{escape(page["figure"])}">' if has_figure else ""
    rows = "\n".join(_render_claim(claim) for claim in results.get("claims", ()))
    heads = "".join(f'<th scope="col">{one}</th>' for one in HEADINGS)
    digest = "\n".join(
        f"<p><strong>{one['heading']}:</strong> {escape(one['text'])}</p>" for one in results.get("digest", ())
    )
    sources = "\n".join(f"<li>{_render_source(one)}</li>" for one in page["sources"])
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="description" content="{about}">
<meta property="og:title" content="{title}">
<meta property="og:description" content="{about}">
<title>{title}</title>
<style>{STYLE}</style>
</head>
<body>
<main>
<h1>{title}</h1>
<p>{about}</p>
<p><a href="../#/studies/{name}">Open this study on the bench</a></p>
{image}
{digest}
<h2>Printed and computed values</h2>
<div><table><thead><tr>{heads}</tr></thead>
<tbody>
{rows}
</tbody></table></div>
<h2>Sources</h2>
<ul>
{sources}
</ul>
<p>Computed by {escape(results.get("made_by", "martensite"))}.</p>
</main>
</body>
</html>
"""


def _render_claim(claim: Mapping[str, Any]) -> str:
    printed = claim["as_printed"] if claim["published"] is None else claim["published"]
    numbers = "".join(f'<td class="number">{_format_number(value)}</td>' for value in (printed, claim["computed"]))
    unit = "" if claim["unit"] == "1" else escape(claim["unit"])
    kind = claim["verdict"].replace(" ", "-")
    return (
        f'<tr class="{kind}"><th scope="row">{escape(claim["statement"])}</th>{numbers}'
        f"<td>{unit}</td><td>{claim['verdict']}</td></tr>"
    )


def _format_number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _render_source(source: Mapping[str, str]) -> str:
    link = escape(source["link"])
    return escape(source["text"]) + (f' <a href="{link}">{link}</a>' if link else "")
