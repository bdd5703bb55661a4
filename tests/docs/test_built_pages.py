"""Pages as they are built: commands as a reader types them, a gallery, and nothing from elsewhere.

Source of truth: the HTML that Sphinx writes of a small page with the settings of `docs/conf.py`.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from html import unescape
from pathlib import Path

import pytest
from fences import ROOT, pages

from martensite.cli.commands.web_bench import build_address

DOCS = ROOT / "docs"
HELPERS = str(DOCS / "_ext")
HEAD = "---\nfile_format: mystnb\nkernelspec:\n  name: python3\n---\n\n# A page\n\n"
PAGE = """\
$$ x^2 $$

```{code-cell} ipython3
!martensite list law --json
```

```{code-cell} ipython3
%%writefile wire.toml
title = "a"
```

```{code-cell} ipython3
:tags: [gallery]
from IPython.display import SVG
SVG("<svg xmlns='http://www.w3.org/2000/svg'/>")
```

```{code-cell} ipython3
from IPython.display import display
display(SVG("<svg xmlns='http://www.w3.org/2000/svg'><path/></svg>"))
print("Text between the drawing and its caption.")
```

Figure: A caption below.

```{toctree}
:caption: A group

further
```

[a link](https://elsewhere.org)
"""
FIRST = """\
# First

```{gallery}
page | A figure | What is in it
```

```{toctree}
page
```
"""
LIVE = """\
```{gallery}
page | A figure | What is in it | wire
```

```{devices}
wire | A device | What it is
```
"""
OURS = ["myst_nb", "executed", "shown", "live", "gallery", "navigation", "sphinx.ext.mathjax"]
LOADS = re.compile(
    r"<(?:script|img|iframe|source|video|audio|embed|object)\b[^>]*?(?:src|data)=[\"']([^\"']*)"
    r"|<link\b(?![^>]*rel=[\"']canonical)[^>]*?href=[\"']([^\"']*)"
    r"|url\(\s*[\"']?([^\"')]+)"
    r"|@import\s+[\"']([^\"']+)"
)
"""What a browser loads for a page, or for a style of it."""
Build = Callable[..., subprocess.CompletedProcess[str]]


def elsewhere(text: str) -> list[str]:
    """What a page or style loads from another host."""
    found = ["".join(groups) for groups in LOADS.findall(text)]
    return [name for name in found if re.match(r"\s*(?:https?:)?//", name)]


@pytest.fixture
def build(tmp_path: Path) -> Build:
    """Builds a first page with a gallery and another one; warnings are errors."""

    def built(first: str, page: str, bench: str = "") -> subprocess.CompletedProcess[str]:
        (tmp_path / "index.md").write_text(first, encoding="utf-8")
        (tmp_path / "page.md").write_text(HEAD + page, encoding="utf-8")
        given = {"pages_begin_with": "processes", "extensions": ",".join(OURS)}
        words = [word for name, value in given.items() for word in ("-D", f"{name}={value}")]
        return subprocess.run(
            [sys.executable, "-m", "sphinx", "-W", "-q", "-c", str(DOCS), *words, "-d", "trees", str(tmp_path), "html"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            env={
                "PYTHONPATH": os.pathsep.join([HELPERS, *sys.path]),
                "HOME": str(tmp_path),
                "MARTENSITE_QUICK_C": "off",
                "MARTENSITE_BENCH": bench,
            },
        )

    return built


def test_a_small_documentation(build: Build, tmp_path: Path) -> None:
    (tmp_path / "further.md").write_text("# A further page\n", encoding="utf-8")
    done = build(FIRST + LIVE, PAGE.replace("[gallery]", "[gallery, live-wire]"))
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "html" / "page.html").read_text("utf-8")
    words = unescape(re.sub(r"<[^>]+>", "", page))
    assert "\nmartensite list law --json" in words
    assert "%%writefile" not in words
    assert 'code-block-caption"><span class="caption-text"><code' in page
    assert 'alt="Figure: A page"' in page
    further = (tmp_path / "html" / "further.html").read_text("utf-8")
    assert all('<li class="menu-group">A group</li><li class="toctree-l2' in one for one in (page, further))
    assert 'alt="Figure: A caption below."' in page and '<p class="figure-caption">Figure: A caption below.' in page
    index = (tmp_path / "html" / "index.html").read_text("utf-8")
    assert "bench/#" not in page + index  # where there is no bench
    figure, *_ = re.findall(r"<figure.*?</figure>", index, re.DOTALL)
    assert 'href="page.html"' in figure
    assert 'alt="What is in it"' in figure
    (image,) = re.findall(r'src="([^"]+)"', figure)
    assert (tmp_path / "html" / image).is_file()

    files = [*(tmp_path / "html").rglob("*.html"), *(tmp_path / "html").rglob("*.css")]
    assert len(files) > 5
    assert [name for file in files for name in elsewhere(file.read_text("utf-8"))] == []
    assert "mathjax/tex-svg.js" in page
    assert '"enableMenu": false' in page  # its menu would load what reads formulas aloud


def test_captions_are_paragraphs() -> None:
    """A caption in the options of a cell would be hidden from the tests of prose, and look different."""
    assert [page.name for page in pages() if re.search(r"^:mystnb:.*caption", page.read_text("utf-8"), re.M)] == []


def test_a_figure_or_scenario_that_is_missing_fails_the_build(build: Build, tmp_path: Path) -> None:
    missing = LIVE.replace("wire | A device", "ring | A device")
    done = build(FIRST + missing, "No figure at all.\n", write_bench(tmp_path / "made"))
    assert done.returncode != 0
    assert "no scenario `ring`" in done.stderr
    assert "no figure for the gallery on page" in done.stderr


def write_bench(folder: Path) -> str:
    """A bench with the scenario of the page, as far as links need it."""
    (folder / "runs").mkdir(parents=True)
    listed = {"scenarios": [{"name": "wire", "text": 'title = "a"\n'}]}
    (folder / "runs" / "manifest.json").write_text(json.dumps(listed), encoding="utf-8")
    return str(folder)


def test_figures_and_files_lead_to_the_bench_beside_them(build: Build, tmp_path: Path) -> None:
    bench = write_bench(tmp_path / "made")
    (tmp_path / "further.md").write_text("# A further page\n", encoding="utf-8")
    done = build(FIRST + LIVE, PAGE.replace("[gallery]", "[gallery, live-wire]"), bench)
    assert done.returncode == 0, done.stderr
    html = [(tmp_path / "html" / f"{name}.html").read_text("utf-8") for name in ("index", "page")]
    links = [re.findall(r'href="(bench/[^"]+)"', text) for text in html]
    assert [len(found) for found in links] == [3, 2]  # of a figure, and of a device twice; of a file and a cell
    assert {unescape(one) for found in links for one in found} == {build_address("bench/", 'title = "a"\n')}
    assert 'src="_static/devices/wire.webp"' in html[0]


@pytest.mark.parametrize(
    "text",
    [
        '<script src="https://cdn.example/a.js"></script>',
        '<link rel="stylesheet" href="//fonts.example/a.css">',
        "<img alt='' src='http://example.org/a.png'>",
        "@font-face { src: url(https://fonts.example/a.woff2) }",
        '@import "https://example.org/a.css";',
    ],
)
def test_what_comes_from_elsewhere_is_noticed(text: str) -> None:
    assert len(elsewhere(text)) == 1


def test_links_may_lead_elsewhere() -> None:
    text = '<a href="https://example.org">x</a> <img src="a.svg"> <link href="a.css">'
    assert elsewhere(text + "<style>a { background: url(data:image/png;base64,aa) }</style>") == []
