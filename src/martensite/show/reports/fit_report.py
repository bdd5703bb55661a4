"""The report of a fit, as a page of HTML or as Markdown with figures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import DataError
from martensite.base.files import replace_file
from martensite.fit.fit_provenance import program, scenario_of
from martensite.show.figures.files import write_figure
from martensite.show.reports import html, markdown
from martensite.show.reports.blocks import Block, Picture
from martensite.show.reports.fit_sections import lead_of, pictures, sections, title_of

if TYPE_CHECKING:
    from martensite.fit.fit import Fit
    from martensite.scenario.scenario import Scenario
    from martensite.search.profile import Profile

HTML, MARKDOWN = (".html", ".htm"), (".md", ".markdown")


def report_files(fit: Fit, path: str | Path, profiles: Sequence[Profile] = ()) -> list[Path]:
    """All files that `write_report` would write or replace, the report first.

    Raises:
        DataError: the path ends in neither .html nor .md.
    """
    path = checked(path)
    if path.suffix.lower() in HTML:
        return [path]
    return [path, *(figure_folder(path) / f"{name}.png" for name in pictures(fit, profiles))]


def write_report(
    fit: Fit,
    path: str | Path,
    *,
    scenario: Scenario | None = None,
    title: str = "",
    profiles: Sequence[Profile] = (),
) -> list[Path]:
    """Write what a fit found, and how far to trust it; existing files are replaced.

    Args:
        fit: a finished fit.
        path: the file to write: .html holds its figures, .md has them in the folder
            `NAME_figures` beside it. The folder of the path must exist.
        scenario: what the fit began with, if the fit does not know; its title, file and material
            are told.
        title: headline; made from the names of the records if left out.
        profiles: profile likelihoods of some parameters.

    Returns:
        The files written, the report first.

    Raises:
        InputError: the path ends in neither .html nor .md, or a file cannot be written.
    """
    path = checked(path)
    blocks = sections(fit, scenario or scenario_of(fit), profiles)
    words = (title or title_of(fit), lead_of(fit), blocks, f"Written by {program()}.")
    if path.suffix.lower() in HTML:
        write_text(path, html.page(*words))
    else:
        write_figures(figure_folder(path), blocks)
        write_text(path, markdown.page(*words, figure_folder(path).name))
    return report_files(fit, path, profiles)


def checked(path: str | Path) -> Path:
    """The path of a report.

    Raises:
        DataError: it ends in neither .html nor .md, or its folder does not exist.
    """
    path = Path(path)
    if path.suffix.lower() not in (*HTML, *MARKDOWN):
        raise DataError(f"A report ends in .html or .md, but this is `{path}`.")
    if not path.parent.is_dir():
        raise DataError(f"The folder of `{path}` does not exist; create it first.")
    return path


def figure_folder(path: Path) -> Path:
    """Where the figures of a report in Markdown lie."""
    return path.with_name(f"{path.stem}_figures")


def write_figures(folder: Path, blocks: Sequence[Block]) -> None:
    """Write all pictures among some blocks into a folder, which is made if it does not exist.

    Raises:
        DataError: the folder cannot be made, or a file cannot be written.
    """
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise DataError(f"Cannot make the folder `{folder}`: {error.strerror}.") from None
    for block in blocks:
        if isinstance(block, Picture):
            write_figure(block.figure, folder / f"{block.name}.png")


def write_text(path: Path, text: str) -> None:
    """Write a text; the file is replaced whole or not at all.

    Raises:
        DataError: the file cannot be written.
    """
    with replace_file(path) as part:
        part.write_text(text, encoding="utf-8")
