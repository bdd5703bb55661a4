"""Experiments with faults, each a function of a seed: what goes in, what is broken, who judges.

    python tests/fault_experiments.py scenarios 17 18    these trials, with all words
    python tests/fault_experiments.py large TRIALS.jsonl [NAME ...]    the large run, or parts of it

`laboratory.faults` writes the page of what came out.

Source of truth: the same work undisturbed, to the last bit, or a sentence.
"""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from command import Command
from fault_surroundings import run_in_hostile_folder, run_with_foreign_cache
from fault_trials import (
    HOSTILE,
    PATIENCE,
    Outcome,
    Trial,
    Verdict,
    count_trials,
    judge_call,
    judge_command,
    judge_differences,
    judge_error,
    judge_result,
    list_places,
    run_trials,
    spoil_bytes,
    spoil_document,
    wait_until,
    work_off,
    write_trials,
)

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
MOST_STEPS = 100_000
"""Of a run that is made."""
BUDGET = 1.5
"""CPU time [s] of a run, after which it gives up."""
RUN_ALONE = tuple(
    f"{name}.toml"
    for name in (
        *("antagonistic_wires", "clamped_wire", "closed_loop", "closed_loop_beam", "closed_loop_guarded"),
        *("closed_loop_platform", "closed_loop_power", "closed_loop_sensorless", "constant_power", "finger"),
        *("finger_design", "hand", "isobaric", "migaone", "platform_spring", "pwm_bias_spring", "tensile-test"),
    )
)
"""Scenarios that run as they are."""


@contextmanager
def fresh_folder() -> Iterator[Path]:
    """A folder to work in, which is the current one meanwhile."""
    before = Path.cwd()
    folder = before / "fresh"
    folder.mkdir()
    os.chdir(folder)
    try:
        yield folder
    finally:
        os.chdir(before)
        shutil.rmtree(folder, ignore_errors=True)


@cache
def list_words() -> tuple[str, ...]:
    """Names of parts, of materials and of entries of the examples."""
    from martensite.scenario.catalogue import list_registries

    texts = [(EXAMPLES / name).read_text(encoding="utf-8") for name in RUN_ALONE]
    entries = {str(key) for text in texts for path in list_places(tomllib.loads(text)) for key in path}
    names = {name for registry in list_registries(True).values() for name in registry.names()}
    materials = {path.stem for path in (ROOT / "src/martensite/physics/materials/data").glob("*.toml")}
    return tuple(sorted(entries | names | materials))


def call_command(words: Sequence[str], *files: str) -> Verdict:
    """A command in this process: how it ends, and whether the files that it promised are there."""
    done = Command(*words)()
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return judge_error(done.exception)
    return judge_command(done.exit_code, done.stdout, done.stderr, [Path(name) for name in files])


# ---------------------------------------------------------------- what is written by hand


def spoil_scenario(seed: int) -> tuple[str, str]:
    """A scenario with one to three faults, and which example it was."""
    from martensite.base.toml_text import as_toml

    rng = random.Random(seed)
    name = rng.choice(RUN_ALONE)
    text = (EXAMPLES / name).read_text(encoding="utf-8")
    if rng.random() < 0.1:
        return spoil_bytes(text.encode(), rng).decode("utf-8", "replace"), name
    document = tomllib.loads(text)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        spoil_document(document, rng, list_words())
    return as_toml(document), name


def load_check_run(text: str, runtime: str = "auto") -> Verdict:
    """Build a scenario, check it, run it."""
    from martensite.app.documents import count_steps
    from martensite.scenario.scenario import load

    Path("wire.toml").write_text(text, encoding="utf-8")
    for name in ("migaone_table2.csv", "kossoski_table2.csv"):
        if name in text:
            shutil.copy(EXAMPLES / name, name)
    scenario = load("wire.toml")
    checked = call_command(["check", "wire.toml", "--json"])
    if checked[0] is not Outcome.ANSWERED and checked[1]:
        return checked  # a negative verdict is printed, with nothing on standard error
    steps = count_steps(scenario) if scenario.bench is None else scenario.duration / scenario.bench.period
    if max(steps, scenario.samples) > MOST_STEPS:
        return Outcome.LEFT_OUT, f"{steps:.3g} steps, {scenario.samples} samples"
    result = scenario.run(budget=BUDGET, runtime=None if scenario.bench else runtime)
    return judge_result(result, scenario.duration, None if scenario.bench else scenario.samples)


def try_scenario(seed: int) -> Verdict:
    """A scenario with faults: load, check, run."""
    with fresh_folder():
        return load_check_run(spoil_scenario(seed)[0], "floats" if seed % 5 else "auto")


COMMANDS = (
    "check wire.toml --set drive.peak=2",
    "run wire.toml --no-figure --out out.nc --tolerance 1e-3",
    "run wire.toml --no-figure --out out.nc --budget 1s --runtime floats",
    "run wire.toml --figure out.png --out out.nc",
    "params wire.toml --json",
    "list law liang-rogers",
    "materials flexinol-90",
    "cite wire.toml",
    "law liang-rogers --path superelastic --out out.csv",
    "export c wire.toml --out . --name core --precision float32",
    "export fmu wire.toml --out out.fmu --fmi 3.0 --sources-only",
    "sweep wire.toml --over diameter=0.1..0.2mm:2 --out out.zarr --runtime floats --step 0.1s --backend serial",
    "identify log.csv --input duty --output position --stage oe(1,1,1) --starts 1 --save out.json",
    "fit log.csv --scenario wire.toml --free cooling.h --starts 1",
    "size --pull 8N --stroke 5mm --rate 0.1Hz --supply 12V",
    "design wire.toml --free element.diameter=0.1..0.2mm --sample 2 --descents 1 --minimise energy",
    "tune wire.toml --method rules --rule simc --form pi",
    "pareto out.zarr --minimise energy --maximise stroke",
    "sensitivity out.zarr --output stroke",
)
PROMISED = {"--out": ("nc", "csv", "fmu", "zarr", "toml"), "--save": ("json", "csv", "toml"), "--figure": ("png",)}
QUICK = """title = "A thin wire"
[element]
kind = "wire"
material = "flexinol-90"
law = "liang-rogers"
diameter = "0.15 mm"
length = "250 mm"
[environment]
temperature = "22 degC"
cooling = { kind = "constant", h = "120 W/m^2/K" }
[mechanism]
kind = "bias-spring"
stiffness = "0.15 N/mm"
preload = "1.2 N"
[drive]
kind = "voltage"
waveform = { kind = "step", high = "3 V", at = "0.1 s", until = "1.3 s" }
[run]
duration = "2 s"
samples = 21
"""


def write_log(rows: int = 120, separator: str = ",") -> str:
    """A log as text: time, duty and position."""
    times = 0.05 * np.arange(rows)
    duty = np.where((times > 1.0) & (times < 4.0), 20.0, 0.0)
    position = 0.1 * np.cumsum(duty) / (1.0 + times)
    lines = [separator.join(("time [s]", "duty [%]", "position [mm]"))]
    lines += [separator.join(f"{x:.6g}" for x in row) for row in zip(times, duty, position, strict=True)]
    return "\n".join(lines) + "\n"


def try_command(seed: int) -> Verdict:
    """A command line with a word too many, too few, or another."""
    rng = random.Random(seed)
    words: list[str] = list(rng.choice(COMMANDS).split())
    text = QUICK if rng.random() < 0.7 else spoil_scenario(seed)[0]
    for _ in range(rng.choice((0, 1, 1, 2))):
        at = rng.randrange(1, len(words) + 1)
        pick = rng.random()
        hostile = str(rng.choice(HOSTILE)).replace("\0", "\N{REPLACEMENT CHARACTER}")
        other = rng.choice((hostile, hostile, rng.choice(list_words()), rng.choice(rng.choice(COMMANDS).split())))
        if pick < 0.3:
            words.insert(at, other)
        elif pick < 0.5 and at < len(words):
            del words[at]
        elif at < len(words):
            words[at] = other
    with fresh_folder():
        Path("wire.toml").write_text(text, encoding="utf-8")
        Path("log.csv").write_text(write_log(), encoding="utf-8")
        files = [
            words[k + 1]
            for k, word in enumerate(words[:-1])
            if words[k + 1].rpartition(".")[2] in PROMISED.get(word, ())
        ]
        found = call_command(words, *files)
        told = " ".join(words)
        return found[0], f"martensite {told[:300]}: {found[1]}"


LINES = ("Calibrating", "1,2,3,4", "nan,nan,nan", '"', "\0\0", "3,inf,1", "--", "1e999,1,1", "time,duty,position")


def spoil_log(rng: random.Random) -> bytes:
    """A text log: in another code, with other separators, garbage lines, or broken bytes."""
    separator = rng.choice((",", ",", ";", "\t", "  "))
    lines = write_log(rng.choice((5, 120)), separator).splitlines()
    for _ in range(rng.choice((0, 0, 1, 3))):
        lines.insert(rng.randrange(len(lines)), rng.choice(LINES))
    for _ in range(rng.choice((0, 0, 1, 3))):
        cells = lines[at := rng.randrange(len(lines))].split(separator)
        cells[rng.randrange(len(cells))] = str(rng.choice(HOSTILE))
        lines[at] = separator.join(cells)
    text = rng.choice(("\n", "\n", "\r\n", "\r")).join(lines)
    raw = text.encode(rng.choice(("utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-32", "cp037")), "replace")
    return spoil_bytes(raw, rng) if rng.random() < 0.5 else raw


def try_log(seed: int) -> Verdict:
    """Garbage for a text log: what is read is finite and complete, or it is refused."""
    from martensite.logs.reader import read_table

    rng = random.Random(seed)
    raw = spoil_log(rng)
    with fresh_folder():
        Path("log.csv").write_bytes(raw)
        if seed % 10 == 0:
            words = "identify log.csv --input duty --output position --stage oe(1,1,1) --starts 1 --json"
            return call_command(list(words.split()))

        def read() -> Verdict:
            record = read_table("log.csv", drop=seed % 2 == 0)
            if not all(np.isfinite(column).all() for column in record.columns.values()):
                return Outcome.NAN, "a sample is no number"
            lines = re.split(r"\r\n|\r|\n", raw.decode("utf-8-sig", "replace"))
            seen = [one for one in lines if one.strip(" \t,;")]
            rows = len([one for one in seen if not one.lstrip().startswith("#")])
            if raw[:2] not in (b"\xff\xfe", b"\xfe\xff") and len(record.times) + record.dropped < rows - 1:
                return Outcome.LOSS, f"{len(record.times)} rows and {record.dropped} dropped, of {rows} lines"
            return Outcome.ANSWERED, f"{len(record.times)} rows"

        return judge_call(read)


# ---------------------------------------------------------------- files of the package's own


def try_model(seed: int) -> Verdict:
    """A model file with faults: a run of it."""
    rng = random.Random(seed)
    text = (EXAMPLES / "model_run.json").read_text(encoding="utf-8")
    if rng.random() < 0.4:
        raw = spoil_bytes(text.encode(), rng)
    else:
        document = json.loads(text)
        spoil_document(document, rng, list_words())
        raw = json.dumps(document).encode()
    with fresh_folder():
        Path("model_run.json").write_bytes(raw)
        return load_check_run((EXAMPLES / "model_run.toml").read_text(encoding="utf-8"))


def try_material(seed: int) -> Verdict:
    """A material file with faults: a run with its numbers."""
    from martensite.base.toml_text import as_toml

    rng = random.Random(seed)
    path = ROOT / "src/martensite/physics/materials/data/flexinol-90.toml"
    text = path.read_text(encoding="utf-8")
    if rng.random() < 0.3:
        raw = spoil_bytes(text.encode(), rng)
    else:
        document = tomllib.loads(text)
        spoil_document(document, rng, list_words())
        raw = as_toml(document).encode("utf-8", "replace")
    with fresh_folder():
        Path("own.toml").write_bytes(raw)
        return load_check_run(QUICK.replace('"flexinol-90"', '"own.toml"'))


@cache
def save_whole() -> tuple[bytes, dict[str, bytes]]:
    """A saved result, and the numbers in it."""
    from martensite.scenario.netcdf import read_labelled, save_result
    from martensite.scenario.scenario import read_scenario

    save_result(read_scenario(QUICK).run(), "whole.nc", QUICK)
    dataset = read_labelled("whole.nc")
    raw = Path("whole.nc").read_bytes()
    Path("whole.nc").unlink()
    return raw, {str(name): dataset[name].values.tobytes() for name in dataset.variables}


def try_saved_result(seed: int) -> Verdict:
    """A damaged netCDF file, read as a result."""
    from martensite.scenario.saved_results import open_result

    raw, _ = save_whole()
    with fresh_folder():
        Path("out.nc").write_bytes(spoil_bytes(raw, random.Random(seed), within=20_000))
        return judge_call(lambda: (Outcome.ANSWERED, f"{len(open_result('out.nc').columns)} columns"))


@cache
def save_log(name: str) -> tuple[bytes, dict[str, Any]]:
    """A log as .mat or .nc: its bytes and its columns."""
    import h5netcdf
    from scipy.io import savemat

    times = 0.02 * np.arange(500)
    columns = {"time": times, "duty": np.where(times > 3.0, 20.0, 0.0), "position": 1.5 * times}
    if name.endswith(".mat"):
        savemat(name, columns, do_compression=name == "packed.mat")
    else:
        with h5netcdf.File(name, "w") as file:
            file.dimensions["time"] = len(times)
            for column, values in columns.items():
                file.create_variable(column, ("time",), data=values)
    raw = Path(name).read_bytes()
    Path(name).unlink()
    return raw, columns


def try_binary_log(seed: int) -> Verdict:
    """A damaged .mat or .nc log: what is read are numbers, or it is refused."""
    from martensite.logs.binary_files import read_arrays

    name = ("plain.mat", "packed.mat", "log.nc")[seed % 3]
    raw, _ = save_log(name)
    with fresh_folder():
        Path(name).write_bytes(spoil_bytes(raw, random.Random(seed), within=3000))

        def read() -> Verdict:
            found = read_arrays(Path(name))
            odd = [heading for heading, values in found.items() if values.dtype.kind not in "iuf"]
            return (Outcome.NAN, f"{odd} are no numbers") if odd else (Outcome.ANSWERED, f"{len(found)} columns")

        return judge_call(read)


# ---------------------------------------------------------------- stores of sweeps


def sweep_store(path: Path, **how: Any) -> Any:
    """Make or go on with the sweep of the experiments."""
    from sweep_cases import wanted, wire

    from martensite.design.sweep.api import SweepExecution, begin_sweep

    given: dict[str, Any] = {"backend": "serial"} | how
    return begin_sweep(wire(), wanted(), path, SweepExecution(**given)).run()


@cache
def make_whole() -> dict[str, bytes]:
    """The arrays of the undisturbed sweep, which lies in `whole.zarr` of the first folder."""
    from sweep_cases import arrays

    sweep_store(Path("whole.zarr"))
    return dict(arrays(Path("whole.zarr")))


def try_store(seed: int) -> Verdict:
    """A store with a file that is damaged or gone: read, and gone on with."""
    from sweep_cases import arrays

    from martensite.design.sweep.reading import read_sweep

    rng = random.Random(seed)
    expected = make_whole()
    shutil.copytree("whole.zarr", "copy.zarr")
    with_files = sorted(path for path in Path("copy.zarr").rglob("*") if path.is_file())
    path = rng.choice(with_files)
    match rng.choice(("gone", "empty", "spoilt", "spoilt", "spoilt", "folder")):
        case "gone":
            path.unlink()
        case "empty":
            path.write_bytes(b"")
        case "folder":
            path.unlink()
            path.mkdir()
        case _:
            path.write_bytes(spoil_bytes(path.read_bytes(), rng))

    def use() -> Verdict:
        if seed % 2:
            read_sweep(Path("copy.zarr"))
        sweep_store(Path("copy.zarr"))
        return judge_differences(dict(arrays(Path("copy.zarr"))), expected)

    try:
        outcome, words = judge_call(use)
        return outcome, f"{path.relative_to('copy.zarr')}: {words}"
    finally:
        shutil.rmtree("copy.zarr", ignore_errors=True)


def open_sweep(*more: str) -> subprocess.Popen[str]:
    """The sweep of the experiments as a command in a group of its own, into `s.zarr`."""
    from sweep_cases import AXES, WIRE

    Path("wire.toml").write_text(WIRE, encoding="utf-8")
    words = ["sweep", "wire.toml", *AXES, "--chunk-size", "3", "--runtime", "floats", "--out", "s.zarr", *more]
    return open_command(*words)


def open_command(*words: str, **environment: str) -> subprocess.Popen[str]:
    """A command in a process group of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", "from martensite.cli import main; main()", *words],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    )


def is_alive(group: int) -> bool:
    """Whether any process of a group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def end_command(process: subprocess.Popen[str], patience: float = 4 * PATIENCE) -> tuple[int, str, str] | None:
    """Exit code and words of a command; None if it does not end, or leaves processes behind."""
    try:
        out, err = process.communicate(timeout=patience)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return None
    if not wait_until(lambda: not is_alive(process.pid), 20.0):
        os.killpg(process.pid, signal.SIGKILL)
        return None
    return process.returncode, out, err


KILLED: dict[str, tuple[str, str]] = {
    "run": ("run wire.toml --out out.nc --figure out.png --force", "out.nc"),
    "identify": ("identify log.csv --stage pwl6|oe(2,2,1) --starts 60 --save out.json", "out.json"),
    "export": ("export fmu wire.toml --out out.fmu --force", "out.fmu"),
}
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)


def try_kill(seed: int) -> Verdict:
    """A command that is killed, ended or interrupted: files are whole or absent, and a sweep goes on."""
    from sweep_cases import arrays

    rng = random.Random(seed)
    which, sign = rng.choice(("sweep", "sweep", *KILLED)), rng.choice(SIGNALS)
    expected = make_whole() if which == "sweep" else {}
    with fresh_folder() as folder:
        Path("wire.toml").write_text(QUICK, encoding="utf-8")
        Path("log.csv").write_text(write_log(600), encoding="utf-8")
        if which == "sweep":
            process = open_sweep(*rng.choice((("--backend", "serial"), ("--workers", "2"))))
        else:
            process = open_command(*KILLED[which][0].split())
        try:
            process.wait(rng.uniform(0.2, 6.0))
        except subprocess.TimeoutExpired:
            os.kill(process.pid, sign)
        done = end_command(process)
        told = f"{which} after {sign.name}"
        if done is None:
            return Outcome.HANG, f"{told}: does not end, or leaves processes behind"
        code, _, err = done
        if "Traceback" in err:
            return Outcome.TRACEBACK, f"{told}: {err[-1500:]}"
        if which == "sweep":
            if code == -signal.SIGTERM and sign != signal.SIGTERM:
                return Outcome.TRACEBACK, f"{told}: exit {code}"
            sweep_store(Path("s.zarr"))
            verdict = judge_differences(dict(arrays(Path("s.zarr"))), expected)
            return verdict[0], f"{told}: {verdict[1]}"
        out = folder / KILLED[which][1]
        if out.exists() and not is_whole(out):
            return Outcome.LOSS, f"{told}: {out.name} is not whole"
        parts = [path.name for path in folder.iterdir() if path.name.startswith(".")]
        return (Outcome.FAILED if code else Outcome.ANSWERED), f"{told}: exit {code}; left behind {parts}"


def is_whole(path: Path) -> bool:
    """Whether a file can be read to its end."""
    import zipfile

    from martensite.scenario.model_files import read_model
    from martensite.scenario.netcdf import read_labelled

    readers = {".nc": read_labelled, ".json": read_model, ".fmu": lambda one: zipfile.ZipFile(one).testzip()}
    return judge_call(lambda: (Outcome.ANSWERED, str(readers[path.suffix](path))))[0] is Outcome.ANSWERED


def try_two_writers(seed: int) -> Verdict:
    """Two commands on one store, one of which may be killed; then a third."""
    from sweep_cases import arrays

    rng = random.Random(seed)
    expected = make_whole()
    with fresh_folder():
        both = [open_sweep("--backend", "serial") for _ in range(2)]
        if killed := rng.random() < 0.6:
            wait_until(lambda: Path("s.zarr").exists(), 20.0)
            time.sleep(rng.uniform(0.0, 0.5))
            both[0].kill()
        for process in both[killed:]:
            done = end_command(process)
            if done is None or done[0] or done[2]:
                outcome = Outcome.HANG if done is None else Outcome.TRACEBACK
                return outcome, f"killed: {killed}; {done}"
        end_command(both[0])
        sweep_store(Path("s.zarr"))
        return judge_differences(dict(arrays(Path("s.zarr"))), expected)


def try_clock(seed: int) -> Verdict:
    """The clock of the machine jumps by years while a sweep is made, and times of files with it."""
    from sweep_cases import arrays

    rng = random.Random(seed)
    expected = make_whole()
    honest = time.time
    try:
        time.time = lambda: honest() + rng.uniform(-1e9, 1e9)
        with fresh_folder():
            sweep_store(Path("s.zarr"), part="1/2")
            for path in Path("s.zarr").rglob("*"):
                os.utime(path, (moment := rng.uniform(0.0, 4e9), moment))
            sweep_store(Path("s.zarr"))
            return judge_differences(dict(arrays(Path("s.zarr"))), expected)
    finally:
        time.time = honest


def try_cluster(seed: int) -> Verdict:
    """A worker of a Dask cluster is killed while a sweep is made."""
    from sweep_cases import arrays, undisturbed, wanted, wire

    from martensite.design.sweep.api import SweepExecution, begin_sweep

    distributed: Any = import_module("distributed")
    rng = random.Random(seed)
    many = "diameter=0.12..0.2 mm:6", "high=2..4 V:10"
    with fresh_folder():
        expected = undisturbed(Path("whole.zarr"), *many, chunk=2)
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            pids = [worker.pid for worker in cluster.workers.values()]
            how = SweepExecution("dask", scheduler=cluster.scheduler_address)
            begun = begin_sweep(wire(), wanted(*many, chunk=2), Path("s.zarr"), how)
            after = rng.randrange(1, 25)

            def tell(now: Any) -> None:
                if now.new_runs >= after and pids:
                    os.kill(pids.pop(), signal.SIGKILL)

            begun.run(tell)
        return judge_differences(dict(arrays(Path("s.zarr"))), expected)


# ---------------------------------------------------------------- disks


@contextmanager
def small_disk(size: int) -> Iterator[Path]:
    """A disk of its own in memory, of so many kB."""
    with fresh_folder() as folder:
        disk = folder / "disk"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", disk], check=True)
        try:
            yield disk
        finally:
            subprocess.run(["umount", "-l", disk], check=True)


def can_mount() -> bool:
    """Whether a disk can be made here."""
    try:
        os.chdir(os.environ.get("TMPDIR", "/tmp"))
        with small_disk(40):
            return True
    except (OSError, subprocess.CalledProcessError):
        return False


WRITTEN = {
    "run wire.toml --no-figure --out disk/out.nc": "out.nc",
    "run wire.toml --figure disk/out.png --out disk/out.nc": "out.nc",
    "identify log.csv --input duty --output position --stage oe(1,1,1) --starts 1 --save disk/out.json": "out.json",
    "identify log.csv --stage oe(1,1,1) --starts 1 --figure disk/out.png": "out.png",
    "law liang-rogers --out disk/out.csv": "out.csv",
    "export c wire.toml --out disk --name core": "core.c",
    "export fmu wire.toml --out disk/out.fmu --sources-only": "out.fmu",
    "size --pull 8N --stroke 5mm --rate 0.1Hz --supply 12V --out disk/out.toml": "out.toml",
    "sweep wire.toml --over diameter=0.1..0.2mm:4 --chunk-size 1 --runtime floats --step 0.1s --backend serial "
    "--out disk/out.zarr": "out.zarr",
}


def write_to_disk(command: str, cache: str = "") -> Verdict:
    """A command whose answer goes to `disk`: whole files or none, and a sentence if none."""
    Path("wire.toml").write_text(QUICK, encoding="utf-8")
    Path("log.csv").write_text(write_log(), encoding="utf-8")
    before = {path.name for path in Path("disk").iterdir()}
    process = open_command(*command.split(), **({"XDG_CACHE_HOME": cache} if cache else {}))
    done = end_command(process)
    if done is None:
        return Outcome.HANG, command
    outcome, words = judge_command(*done, files=[] if cache else [Path("disk") / WRITTEN[command]])
    left = {path.name for path in Path("disk").iterdir()} - before - {"out.zarr", "cache"}
    if outcome in (Outcome.REFUSED, Outcome.FAILED) and left:
        return Outcome.LOSS, f"{command}: left {sorted(left)}; {words}"
    return outcome, f"{command}: {words}"


def try_full_disk(seed: int) -> Verdict:
    """A disk with little left, to which a command writes."""
    rng = random.Random(seed)
    with small_disk(400) as disk:
        (disk / "filler").write_bytes(bytes(1024 * (400 - rng.choice((0, 4, 8, 20, 40, 100)))))
        return write_to_disk(sorted(WRITTEN)[seed % len(WRITTEN)])


def try_read_only(seed: int) -> Verdict:
    """A folder for the answer that cannot be written to."""
    with small_disk(400) as disk:
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        return write_to_disk(sorted(WRITTEN)[seed % len(WRITTEN)])


COMPILED = (
    "run wire.toml --runtime c --no-figure --out out.nc",
    "sweep wire.toml --over diameter=0.1..0.2mm:2 --out out.zarr",
    "check wire.toml",
)


def try_read_only_cache(seed: int) -> Verdict:
    """A folder for what is compiled that cannot be written to, or is full."""
    with small_disk(40) as disk:
        if seed % 2:
            (disk / "filler").write_bytes(bytes(40 * 1024))
        else:
            subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        return write_to_disk(COMPILED[seed // 2 % len(COMPILED)], cache=str(disk))


# ---------------------------------------------------------------- what leaves the package

SANITIZED = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def change_numbers(name: str, rng: random.Random) -> list[str]:
    """Settings that change numbers of an example by a factor."""
    document = tomllib.loads((EXAMPLES / name).read_text(encoding="utf-8"))
    found: list[str] = []
    for path in rng.sample(list(list_places(document)), 3):
        value: Any = document
        for key in path:
            value = value[key]
        words = value.split() if isinstance(value, str) else []
        named = all(isinstance(key, str) for key in path)
        if named and len(words) == 2 and words[0].replace(".", "", 1).isdigit():
            number = float(words[0]) * rng.choice((0.5, 0.9, 1.1, 2.0))
            found += ["--set", f"{'.'.join(map(str, path))}={number!r} {words[1]}"]
    return found


def run_freely(words: list[str], **environment: str) -> tuple[int, str, str]:
    """A program without the limit on memory, which sanitizers cannot live with; at most a minute."""
    given = [f"{name}={value}" for name, value in environment.items()]
    command = ["sh", "-c", 'ulimit -S -v unlimited; exec timeout -s KILL 60 env "$@"', "sh", *given, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def judge_program(code: int, out: str, err: str) -> Verdict:
    """What an exported program did under sanitizers."""
    if code in (137, -9):
        return Outcome.HANG, "it did not end within a minute"
    if any(word in err for word in ("Sanitizer", "runtime error", "Traceback")) or code < 0 or code > 2:
        return Outcome.TRACEBACK, f"exit {code}: {err[-2000:]}"
    if code:
        return Outcome.FAILED, err[-300:]
    if "nan" in out.lower():
        return Outcome.NAN, next(line for line in out.splitlines() if "nan" in line.lower())
    return Outcome.ANSWERED, f"{len(out.splitlines())} lines"


def try_exported_c(seed: int) -> Verdict:
    """Exported C, compiled with the sanitizers of addresses and of undefined behaviour, and run."""
    rng = random.Random(seed)
    name, precision = RUN_ALONE[seed % len(RUN_ALONE)], ("float64", "float32")[seed // len(RUN_ALONE) % 2]
    with fresh_folder():
        words = ["export", "c", str(EXAMPLES / name), "--name", "core", "--precision", precision]
        found = call_command([*words, *change_numbers(name, rng)], "core.c", "core_example.c")
        if found[0] is not Outcome.ANSWERED:
            return found[0], f"{name} {precision}: {found[1]}"
        built = run_freely(["gcc", "-std=c99", *SANITIZED, "core.c", "core_example.c", "-o", "core", "-lm"])
        if built[0]:
            return Outcome.TRACEBACK, built[2][-1500:]
        outcome, words = judge_program(*run_freely(["./core"]))
        return outcome, f"{name} {precision}: {words}"


DRIVEN = """
import math, random, sys
from pathlib import Path
from fmu_instance import Instance
rng, one = random.Random({seed}), Instance(Path("core.fmu"))
one.begin()
time, names = 0.0, [name for name in one.names if name != "time"]
hostile = (0.0, -1.0, 1e-300, 1e30, 1e308, -1e308, math.nan, math.inf, 0.5, 3.0)
for k in range(40):
    pick = rng.random()
    if pick < 0.5:
        one.set({{rng.choice(names): rng.choice(hostile)}})
    elif pick < 0.6:
        one.status("getReal" if one.second else "getFloat64", [rng.choice((0, 7, 10**6, 2**32 - 1))])
    elif pick < 0.65 and one.second:
        state = one.fmu.getFMUstate()
        raw = bytearray(one.fmu.serializeFMUstate(state))
        one.fmu.freeFMUstate(state)
        for _ in range(rng.choice((0, 1, 9))):
            raw[rng.randrange(len(raw))] ^= 1 << rng.randrange(8)
        one.status("deSerializeFMUstate", bytes(raw[: len(raw) - rng.choice((0, 0, 8))]))
    step = rng.choice((0.01, 0.1, 0.1, 1e-9, 0.0, -1.0, 1e9 if pick < 0.05 else 0.2))
    if one.step(time, step) == 0:
        time += step
        seen = one.get(*names)
        if not all(map(math.isfinite, seen)):
            print("nan", [n for n, x in zip(names, seen) if not math.isfinite(x)][:5], one.said[-2:])
            break
one.close()
"""


def try_fmu(seed: int) -> Verdict:
    """An FMU whose binary has the sanitizers in it, with hostile inputs, states and steps."""
    name, version = RUN_ALONE[seed % len(RUN_ALONE)], ("2.0", "3.0")[seed % 2]
    library = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    with fresh_folder():
        flags = " ".join(SANITIZED)
        step = () if name.startswith("closed_loop") else ("--step", "10 ms")
        words = ("export", "fmu", str(EXAMPLES / name), "--fmi", version, "--out", "core.fmu", "--name", "core")
        export = open_command(*words, *step, MARTENSITE_CFLAGS=flags)
        done = end_command(export)
        if done is None or done[0]:
            return (Outcome.HANG, name) if done is None else judge_command(*done)
        Path("driven.py").write_text(DRIVEN.format(seed=seed), encoding="utf-8")
        asan = {"LD_PRELOAD": library.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}
        outcome, told = judge_program(*run_freely([sys.executable, "-W", "ignore", "driven.py"], **asan))
        return outcome, f"{name} FMI {version}: {told}"


# ---------------------------------------------------------------- pages

TITLES = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "</title><script>alert(1)</script>",
    "javascript:alert(1)",
    "`<b>x</b>`",
    "&lt;script&gt;",
    "]]><svg onload=alert(1)>",
    "{{7*7}} ${7*7} %s",
    "<!-- ",
    "' onmouseover='alert(1)",
    "\u202egnp.exe",
    "[x](javascript:alert(1))",
    "**x** _y_ # z",
)


class Page(HTMLParser):
    """What a browser would run, and what a reader would see."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.text, self.active, self.title = "", list[str](), False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.active += [tag] * (tag in ("script", "iframe", "object", "embed", "form", "b-x"))
        for name, value in attrs:
            code = name in ("href", "src", "action") and (value or "").strip().lower().startswith("javascript:")
            self.active += [f"{tag} {name}={value}"] * (name.startswith("on") or code)

    def handle_data(self, data: str) -> None:
        self.text += data


def try_title(seed: int) -> Verdict:
    """A hostile title, name or sentence in every kind of page: shown as it is, and not run."""
    from martensite.scenario.scenario import read_scenario
    from martensite.show.html import render_fragment, render_page

    summary, said = summarise_hostile(seed)
    which = seed % 3
    if which == 0:
        page = render_page(summary, said)
    elif which == 1:
        page = render_fragment(summary)
    else:
        page = read_scenario(QUICK, overrides={"title": said}).run()._repr_html_()
    return judge_page(page, said, shown=which < 2)


def try_markdown_title(seed: int) -> Verdict:
    """A hostile title in Markdown, which whoever renders it may pass on as HTML."""
    from martensite.show.pages import render_markdown

    summary, said = summarise_hostile(seed)
    return judge_page(render_markdown(summary, said, "figures"), said, shown=False)


def summarise_hostile(seed: int) -> tuple[Any, str]:
    """A summary with something hostile in all its places."""
    from martensite.base.summary import BulletList, DataTable, Heading, Notice, Sentence, Summary

    rng = random.Random(seed)
    said = rng.choice(TITLES) + rng.choice(("", " wire", rng.choice(TITLES)))
    blocks = [Heading(said), Sentence(said, "caution"), DataTable((said, "b"), [(said, "1")]), BulletList([said])]
    return Summary(said, [rng.choice(blocks), Notice(said, [said], True)] if rng.random() < 0.5 else blocks, {}), said


def judge_page(page: str, said: str, shown: bool) -> Verdict:
    """Nothing that was said runs; and it can be read as it was said."""
    read = Page()
    read.feed(page)
    if read.active:
        return Outcome.TRACEBACK, f"{said!r} runs as {read.active[:2]}"
    words = "".join(said.replace("`", "").split())
    lost = shown and words not in "".join(read.text.replace("`", "").split())
    return (Outcome.LOSS, f"{said!r} is not shown") if lost else (Outcome.ANSWERED, said)


def write_inputs() -> None:
    """The scenario and the logs of commands in hostile surroundings."""
    Path("wire.toml").write_text(QUICK, encoding="utf-8")
    for name in ("log.mat", "log.nc"):
        raw, _ = save_log(name)
        Path(name).write_bytes(raw)


def try_hostile_folder(seed: int) -> Verdict:
    """A command in a folder with modules such as numpy.py: none of them runs."""
    with fresh_folder() as folder:
        return run_in_hostile_folder(seed, folder, write_inputs)


def try_foreign_cache(seed: int) -> Verdict:
    """A cache of compiled programs that another user owns or may write: none of the programs runs."""
    with fresh_folder():
        return run_with_foreign_cache(seed, write_inputs)


EXPERIMENTS: dict[str, Callable[[int], Verdict]] = {
    "scenarios": try_scenario,
    "commands": try_command,
    "logs": try_log,
    "models": try_model,
    "materials": try_material,
    "saved results": try_saved_result,
    "binary logs": try_binary_log,
    "stores": try_store,
    "kills": try_kill,
    "two writers": try_two_writers,
    "clocks": try_clock,
    "clusters": try_cluster,
    "full disks": try_full_disk,
    "read-only folders": try_read_only,
    "read-only caches": try_read_only_cache,
    "exported C": try_exported_c,
    "FMUs": try_fmu,
    "titles": try_title,
    "Markdown titles": try_markdown_title,
    "hostile folders": try_hostile_folder,
    "foreign caches": try_foreign_cache,
}
CAPS = {
    "scenarios": 40.0,
    "commands": 60.0,
    "models": 40.0,
    "materials": 40.0,
    "clusters": 60.0,
    "stores": 20.0,
    "foreign caches": 40.0,
}
"""CPU time [s] of a trial; 10 s for others."""
LARGE = {
    "scenarios": 10_000,
    "commands": 500,
    "logs": 2000,
    "models": 500,
    "materials": 500,
    "saved results": 200,
    "binary logs": 300,
    "stores": 200,
    "kills": 40,
    "two writers": 10,
    "clocks": 20,
    "clusters": 5,
    "full disks": 36,
    "read-only folders": 18,
    "read-only caches": 6,
    "exported C": 34,
    "FMUs": 34,
    "titles": 400,
    "Markdown titles": 100,
    "hostile folders": 40,
    "foreign caches": 16,
}
"""Trials of the large run."""


def list_wanted(name: str, count: int, first: int = 0) -> list[tuple[str, int]]:
    """Trials of an experiment, from a seed on."""
    return [(name, seed) for seed in range(first, first + count)]


def main(command: str, *words: str) -> None:
    if command == "work":
        out = os.fdopen(os.dup(1), "w")
        os.dup2(2, 1)
        return work_off(EXPERIMENTS, CAPS, out)
    found: list[Trial] = []
    if command == "large":
        for name in words[1:] or LARGE:
            found += run_trials(list_wanted(name, LARGE[name]), cap=300.0)
            write_trials(found, Path(words[0]))
        found = [trial for trial in found if not trial.fine]
    else:
        found = run_trials([(command, int(word)) for word in words], cap=300.0)
    sys.stdout.write("".join(f"{trial}\n" for trial in found))
    sys.stdout.write(json.dumps(count_trials(found), indent=1) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
