"""Writes documentation and bench as one folder for a file server: `make site`.

    FOLDER/         the documentation, whose figures lead to the bench
    FOLDER/bench/   the web bench without a server: scenarios of the package, and those that pages write

The bench comes first, since pages link to what is in it. Its modules are part of the package.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import live
from drawings import shorten_drawing

from martensite.app.documents import check_files
from martensite.app.static_site.site_writer import can_offer, list_offered, measure_folder, write_site
from martensite.base.errors import DataError, MartensiteError

DOCS = Path(__file__).resolve().parents[1]
TREES = DOCS / "_build" / "site"
MOST = 10e6
"""Bytes of the whole folder as they go over the wire: servers of files compress pages and drawings."""
FILE = re.compile(r"^%%writefile ([\w-]+)\.toml\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def list_documented(docs: Path = DOCS) -> dict[str, str]:
    """Scenarios that pages write and the bench can run, by the names of their files; the same one once."""
    found: dict[str, str] = {}
    for page in sorted(docs.rglob("*.md")):
        for name, text in FILE.findall(page.read_text("utf-8")):
            if text not in found.values() and is_offered(text):
                found[f"{page.stem}-{name}" if name in found else name] = text
    return found


def is_offered(text: str) -> bool:
    """Whether it is a whole scenario without files of its own that starts at home."""
    try:
        check_files(text, {})
        return can_offer(text)
    except MartensiteError:  # another sort of file, or one with parts that the page defines
        return False


def clear_folder(folder: Path) -> None:
    """Take away an earlier site; `DataError` if something else is there."""
    if folder.exists() and any(folder.iterdir()):
        if not (folder / live.BESIDE / "runs" / "manifest.json").is_file():
            raise DataError(f"`{folder}` holds something else than a site of this documentation; name another folder.")
        shutil.rmtree(folder)


def report_size(folder: Path) -> str:
    """What the folder weighs, in a sentence.

    Raises:
        DataError: it is too heavy.
    """
    whole, bench = measure_folder(folder), measure_folder(folder / live.BESIDE)
    words = f"{folder}: {whole.words()}; of these the bench: {bench.words()}"
    if whole.compressed > MOST:
        raise DataError(f"{words}. That is more than {MOST / 1e6:.0f} MB compressed.")
    return words


def make_site(folder: Path) -> None:
    """Write the whole site."""
    clear_folder(folder)
    bench = folder / live.BESIDE
    write_site(bench, list_offered() | list_documented(), print)
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q", "-d", TREES, DOCS, folder]
    subprocess.run(command, env=os.environ | {"MARTENSITE_BENCH": str(bench.resolve())}, check=True)
    for drawing in (folder / "_images").glob("*.svg"):
        drawing.write_text(shorten_drawing(drawing.read_text("utf-8")), encoding="utf-8")
    (folder / ".buildinfo").unlink(missing_ok=True)
    print(report_size(folder))
    print(f"See it with: python -m http.server --directory {folder}")


if __name__ == "__main__":
    try:
        make_site(Path(sys.argv[1]))
    except MartensiteError as error:
        sys.exit(f"make site: {error}")
    except subprocess.CalledProcessError:
        sys.exit("make site: the documentation cannot be built, see above")
