"""Published data sets: nothing is kept or read whose hash is not the one listed."""

from __future__ import annotations

import gzip
import hashlib
import os
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from martensite.base.caches import cache_folder
from martensite.base.errors import DataError, UnknownNameError
from martensite.logs import datasets
from martensite.logs.layout import read_headings
from martensite.logs.reader import read_table
from martensite.scenario.citations import list_entries

CONTENT = {"cycle_a.txt": b"20 0.04\n80 0.01\n", "cycle_b.txt": b"20 0.05\n80 0.02\n"}
ENTRY = '[[files]]\nname = "{name}"\nupstream = "raw_{name}"\nsha256 = "{sha}"\n'
HEAD = """
title = "Two cycles"
summary = "Made up."
caution = "None."
licence = "MIT"
notice = "Copyright (c) nobody"
cite = "leal2016"
page = "https://example.invalid/page"
base = "{base}"
[layout]
columns = ["temperature [degC]", "strain [1]"]
separator = "whitespace"
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """Nothing outside the test's folder is looked at."""
    monkeypatch.delenv(datasets.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "martensite"


@pytest.fixture
def upstream(tmp_path):
    """A folder that plays the authors' server."""
    folder = tmp_path / "upstream"
    folder.mkdir()
    for name, content in CONTENT.items():
        (folder / f"raw_{name}").write_bytes(content)
    return folder


@pytest.fixture
def listed(tmp_path, monkeypatch, upstream):
    """List the data set `two-cycles`, served from a folder unless another base is given."""
    folder = tmp_path / "listed"
    folder.mkdir()
    monkeypatch.setattr(datasets, "_LISTED", folder)

    def write(base="", entry=ENTRY):
        files = [entry.format(name=name, sha=hashlib.sha256(content).hexdigest()) for name, content in CONTENT.items()]
        text = HEAD.format(base=base or f"{upstream.as_uri()}/") + "\n".join(files)
        (folder / "two-cycles.toml").write_text(text, encoding="utf-8")

    write()
    return write


@pytest.fixture
def server(upstream):
    """A real HTTP server on this machine; returns its address."""

    class Quiet(SimpleHTTPRequestHandler):
        def __init__(self, *args):
            super().__init__(*args, directory=str(upstream))

        def log_message(self, format, *args):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield f"http://127.0.0.1:{running.server_port}/"
        running.shutdown()
        thread.join()


def files_below(folder):
    return sorted(path.name for path in Path(folder).rglob("*") if path.is_file())


def test_fetch_over_http_then_read(listed, server, own_cache):
    listed(base=server)
    steps = []
    folder = datasets.fetch_dataset("two-cycles", progress=lambda *step: steps.append(step))
    assert folder == own_cache / "two-cycles"
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == CONTENT
    assert steps == [("cycle_a.txt", 1, 2), ("cycle_b.txt", 2, 2)]
    record = read_table("data:two-cycles/cycle_b.txt", interval=0.5)
    assert record.name == "two-cycles/cycle_b.txt"
    assert record["strain"].tolist() == [0.05, 0.02]
    assert record["temperature"] == pytest.approx([293.15, 353.15], rel=1e-15)
    assert record.times.tolist() == [0.0, 0.5]


def test_fetch_keeps_what_is_there(listed, upstream):
    datasets.fetch_dataset("two-cycles")
    for path in upstream.iterdir():
        path.unlink()
    datasets.fetch_dataset("two-cycles")
    with pytest.raises(DataError, match="Cannot download"):
        datasets.fetch_dataset("two-cycles", force=True)
    assert datasets.locate_file("two-cycles/cycle_a.txt").read_bytes() == CONTENT["cycle_a.txt"]


def test_a_corrupted_download_leaves_nothing_behind(listed, upstream, own_cache):
    (upstream / "raw_cycle_a.txt").write_bytes(b"<html>sorry</html>")
    with pytest.raises(DataError, match=r"raw_cycle_a.txt holds is not the file.*nothing was kept"):
        datasets.fetch_dataset("two-cycles")
    assert files_below(own_cache) == []


def test_a_corrupted_download_does_not_replace_a_good_file(listed, upstream, own_cache):
    datasets.fetch_dataset("two-cycles")
    (upstream / "raw_cycle_a.txt").write_bytes(b"20 0.04\n80 0.09\n")
    with pytest.raises(DataError, match="nothing was kept"):
        datasets.fetch_dataset("two-cycles", force=True)
    assert files_below(own_cache) == sorted(CONTENT)
    assert datasets.locate_file("two-cycles/cycle_a.txt").read_bytes() == CONTENT["cycle_a.txt"]


def test_a_truncated_answer_leaves_nothing_behind(listed, own_cache, upstream):
    class Liar(SimpleHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Length", "1000")
            self.end_headers()
            self.wfile.write(b"20 0.04\n")

        def log_message(self, format, *args):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Liar) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        listed(base=f"http://127.0.0.1:{running.server_port}/")
        try:
            with pytest.raises(DataError, match=r"Cannot download .*MARTENSITE_DATA to that"):
                datasets.fetch_dataset("two-cycles")
        finally:
            running.shutdown()
            thread.join()
    assert files_below(own_cache) == []


def test_a_missing_page_is_named(listed, server, upstream):
    listed(base=server)
    (upstream / "raw_cycle_a.txt").unlink()
    with pytest.raises(DataError, match=r"raw_cycle_a.txt \(answer 404\)"):
        datasets.fetch_dataset("two-cycles")


def test_offline_tells_how_to_use_a_folder(listed):
    listed(base="http://127.0.0.1:9/")  # the discard port: nothing listens
    with pytest.raises(DataError, match=r"no network.*`two-cycles/cycle_a.txt`.*MARTENSITE_D"):
        datasets.fetch_dataset("two-cycles")


def test_a_changed_local_file_is_refused(listed):
    path = datasets.fetch_dataset("two-cycles") / "cycle_a.txt"
    path.write_bytes(b"20 0.04\n80 0.02\n")
    with pytest.raises(DataError, match=r"is not the file that data set `two-cycles` lists"):
        read_table("data:two-cycles/cycle_a.txt")
    with pytest.raises(DataError, match=r"martensite data fetch two-cycles --force"):
        datasets.fetch_dataset("two-cycles")
    datasets.fetch_dataset("two-cycles", force=True)
    assert path.read_bytes() == CONTENT["cycle_a.txt"]


def test_what_is_not_there_is_said_with_the_command(listed):
    with pytest.raises(DataError, match=r"not on this machine; run `martensite data fetch two-cy"):
        datasets.locate_file("two-cycles/cycle_a.txt")


@pytest.mark.parametrize("folder", ["two-cycles", "two_cycles"])
def test_an_own_folder_comes_first(listed, tmp_path, monkeypatch, folder):
    datasets.fetch_dataset("two-cycles")
    own = tmp_path / "own"
    (own / folder).mkdir(parents=True)
    (own / folder / "cycle_a.txt").write_bytes(CONTENT["cycle_a.txt"])
    monkeypatch.setenv(datasets.VARIABLE, str(own))
    assert datasets.locate_file("two-cycles/cycle_a.txt") == own / folder / "cycle_a.txt"
    assert datasets.locate_file("two-cycles/cycle_b.txt").parent.parent == cache_folder()
    assert datasets.fetch_dataset("two-cycles") == own / folder
    assert files_below(own) == sorted(CONTENT)


def test_fetching_into_an_own_folder_that_is_empty(listed, tmp_path, monkeypatch, own_cache):
    monkeypatch.setenv(datasets.VARIABLE, str(tmp_path / "own"))
    assert datasets.fetch_dataset("two-cycles") == tmp_path / "own" / "two-cycles"
    assert files_below(own_cache) == []


def test_a_folder_that_cannot_be_written(listed, tmp_path, monkeypatch):
    (tmp_path / "own").write_text("a file, not a folder")
    monkeypatch.setenv(datasets.VARIABLE, str(tmp_path / "own"))
    with pytest.raises(DataError, match=r"Cannot make the folder `.*two-cycles`: "):
        datasets.fetch_dataset("two-cycles")


def test_an_address_that_is_not_on_record(listed, tmp_path, monkeypatch):
    listed(entry=ENTRY.replace('upstream = "raw_{name}"\n', ""))
    sentence = r"not on record: look for it at https://example.invalid/page, save it as `two-cycles"
    with pytest.raises(DataError, match=sentence):
        datasets.fetch_dataset("two-cycles")
    with pytest.raises(DataError, match=sentence):
        datasets.locate_file("two-cycles/cycle_a.txt")


def test_unknown_names_are_answered_with_the_nearest(listed):
    with pytest.raises(UnknownNameError, match=r"data set named `two-cycle`. Did you mean `two-cy"):
        datasets.fetch_dataset("two-cycle")
    with pytest.raises(UnknownNameError, match=r"file of data set .* Did you mean `cycle_a.txt`"):
        read_table("data:two-cycles/cycl_a.txt")
    with pytest.raises(UnknownNameError, match=r"No file of data set `two-cycles` named ``"):
        datasets.locate_file("two-cycles")


def test_a_name_cannot_lead_out_of_its_folder(listed):
    with pytest.raises(UnknownNameError, match="No data set"):
        datasets.describe_dataset("../listed/two-cycles")
    with pytest.raises(UnknownNameError, match="No file"):
        datasets.locate_file("two-cycles/../two-cycles/cycle_a.txt")


def test_the_cache_follows_the_platform(monkeypatch, tmp_path):
    assert cache_folder() == tmp_path / "cache" / "martensite"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    for platform, folder in [("linux", ".cache"), ("darwin", "Library/Caches")]:
        monkeypatch.setattr("sys.platform", platform)
        assert cache_folder() == tmp_path / folder / "martensite"
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "Local"))
    assert cache_folder() == tmp_path / "Local" / "martensite" / "Cache"


@pytest.mark.parametrize("name", datasets.dataset_names())
def test_every_listed_set_is_complete(name):
    dataset = datasets.describe_dataset(name)
    assert dataset.files
    assert list_entries([dataset.cite])
    assert dataset.licence in ("MIT", "BSD-3-Clause") or dataset.licence.startswith("none stated")
    assert dataset.notice.startswith("Copyright")
    assert all((dataset.title, dataset.summary, dataset.caution))
    assert dataset.base.startswith("https://raw.githubusercontent.com/")
    assert dataset.base.endswith("/")
    for key, file in dataset.files.items():
        assert key == file.name
        assert len(bytes.fromhex(file.sha256)) == 32
        assert file.layout.columns
        assert read_headings(file.layout.columns, key)


PACKAGED = [name for name in datasets.dataset_names() if datasets.describe_dataset(name).packaged]


@pytest.mark.parametrize("name", PACKAGED)
def test_packaged_sets_are_read_without_a_network(name):
    """The files in the package are, unpacked, those listed; their licence lies beside them."""
    dataset = datasets.describe_dataset(name)
    assert dataset.packaged is not None
    assert dataset.notice in (dataset.packaged / "LICENSE").read_text("utf-8")
    for file in dataset.files.values():
        assert file.upstream
        record = read_table(f"data:{name}/{file.name}")
        assert len(record) >= 400
        assert record.name == f"{name}/{file.name}"
    assert datasets.fetch_dataset(name) == dataset.packaged


def test_the_isobaric_sets_are_in_the_package():
    assert set(PACKAGED) == {"flexinol-isobaric", "nitihf-isobaric"}


@pytest.mark.parametrize("spoil", [lambda raw: raw[:30], lambda raw: b"no gzip", lambda raw: b""])
def test_a_damaged_packed_file_is_refused(spoil, tmp_path):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(spoil(gzip.compress(b"t [s],T [K]\n" + b"1,300\n" * 3000, mtime=0)))
    with pytest.raises(DataError, match="cannot be unpacked"):
        read_table(path)


OWN = os.environ.get(datasets.VARIABLE, "")


@pytest.mark.skipif(not OWN, reason="MARTENSITE_DATA names no folder with the measurements")
@pytest.mark.parametrize("name", datasets.dataset_names())
def test_every_listed_file_that_is_here_can_be_read(name, monkeypatch):
    monkeypatch.setenv(datasets.VARIABLE, OWN)
    found = 0
    for file in datasets.describe_dataset(name).files:
        try:
            datasets.locate_file(f"{name}/{file}")
        except DataError as error:
            if "not on this machine" not in str(error):
                raise
            continue
        found += 1
        if file.endswith(".hdf5"):  # no table: has a reader of its own
            continue
        record = read_table(f"data:{name}/{file}")
        assert len(record) >= 400
        assert record.dropped <= 0.01 * len(record)
        warm = [record[one] for one in ("temperature", "apparent_temperature") if one in record.columns]
        assert all(280.0 < one.min() and one.max() < 700.0 for one in warm)
    if not found:
        pytest.skip(f"no file of {name} in MARTENSITE_DATA")
