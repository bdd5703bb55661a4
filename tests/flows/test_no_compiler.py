"""Everything but JAX itself works where JAX is not installed; without a compiler, one is named."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from fences import ROOT

from martensite.kernels import compiler

HIDDEN = """
import sys

sys.modules["jax"] = sys.modules["jaxlib"] = None  # as if it were not installed

import martensite as ms
from martensite.base.errors import MartensiteError

scenario = ms.load("{examples}/pwm_bias_spring.toml")
system, waveform = scenario.system, scenario.waveform
assert scenario.run().stroke > 0.0
slopes = ms.simulate.compute_sensitivity(system, waveform, 20.0, ["preload"], step=0.02, samples=51)
assert slopes.of_range()["mechanism.preload"] != 0.0
batch = ms.run(system, waveform, 2.0, over={{"preload": ["1 N", 2.0]}}, step=0.02, samples=5)
assert not batch.status.failed and batch["position"].shape == (2, 5)
try:
    ms.run(system, waveform, 1.0, runtime="jax")
except MartensiteError as error:
    print(error)
"""


def run(text: str, folder: Path) -> str:
    done = subprocess.run([sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_runs_batches_and_derivatives_need_no_jax(tmp_path: Path, c_compiler: str) -> None:
    found = run(HIDDEN.format(examples=ROOT / "examples"), tmp_path)
    assert "JAX is not installed; install it with `pip install 'martensite[jax]'`" in found


def test_a_packaged_compiler_is_taken_where_the_machine_has_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, c_compiler: str
) -> None:
    """Its words reach the compiler but one, which it does not know."""
    package = tmp_path / "ziglang"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "__main__.py").write_text("import sys\nprint(*sys.argv[1:])\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("shutil.which", lambda name: None)
    compiler._find_zig.cache_clear()
    try:
        found = compiler.find_compiler()
        assert found is not None
        words = [found, "-O3", "-fno-tree-pre", "-o", "a b.so"]
        said = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        assert said.strip() == "cc -O3 -o a b.so"
    finally:
        compiler._find_zig.cache_clear()


def test_without_any_compiler_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setattr(compiler, "find_spec", lambda name: None)
    compiler._find_zig.cache_clear()
    assert compiler.find_compiler() is None
    compiler._find_zig.cache_clear()
