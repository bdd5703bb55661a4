"""A packaged C compiler is found where the machine has none; derivatives name it where there is no compiler."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import pytest
from builders import hanging_wire

from martensite.base.errors import CompileError
from martensite.kernels import compiler
from martensite.signals.constant import Constant
from martensite.simulate import march_kernel
from martensite.simulate.batch import compute_sensitivity


def test_a_packaged_compiler_is_taken_where_the_machine_has_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, c_compiler: str
) -> None:
    """Its words reach the compiler but those which it does not know."""
    package = tmp_path / "ziglang"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "__main__.py").write_text("import sys\nprint(*sys.argv[1:])\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", "")
    compiler._find_zig.cache_clear()
    try:
        found = compiler.find_compiler()
        assert found is not None
        words = [found, "-O3", *compiler.GCC_ONLY, "-o", "a b.so"]
        said = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        assert said.strip() == "cc -O3 -o a b.so"
    finally:
        compiler._find_zig.cache_clear()


def test_clang_compiles_without_flags_of_gcc(c_compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Clang itself where it is installed, otherwise a program that refuses the same flags."""
    refused = "|".join(compiler.GCC_ONLY)
    text = f"""#!/bin/sh
for word; do case $word in {refused}) echo "clang: error: unknown argument: '$word'" >&2; exit 1 ;; esac; done
exec gcc "$@"
"""
    (tmp_path / "clang").write_text(text)
    (tmp_path / "clang").chmod(0o755)
    monkeypatch.setenv("CC", shutil.which("clang") or str(tmp_path / "clang"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    library = compiler.load_library(
        "double twice(double x) { return 2.0 * x; }", march_kernel.FUSED + march_kernel.SINGLE
    )
    library.twice.restype = ctypes.c_double
    assert library.twice(ctypes.c_double(2.0)) == 4.0


def test_without_any_compiler_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(compiler, "find_spec", lambda name: None)
    compiler._find_zig.cache_clear()
    assert compiler.find_compiler() is None
    with pytest.raises(CompileError, match="Derivatives need a C compiler"):
        compute_sensitivity(hanging_wire(), Constant(level=1.0), 1.0, ["h"], step=0.1)
    compiler._find_zig.cache_clear()


def test_a_compiler_that_is_installed_later_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compiler, "_find_zig", lambda: None)
    assert compiler.find_compiler() is None
    (tmp_path / "gcc").write_text("#!/bin/sh\n")
    (tmp_path / "gcc").chmod(0o755)
    assert compiler.find_compiler() == str(tmp_path / "gcc")
