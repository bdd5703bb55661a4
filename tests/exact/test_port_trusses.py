"""Trusses of one and of a hundred elements behind `UMAT`: in a driver with Newton's method, and in CalculiX.

Source of truth: equilibrium; the order of Newton's method with the exact tangent; for equal elements the one of them.
"""

from __future__ import annotations

import copy
import itertools
import math
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import example
from port_hosts import ZERO, UmatHost, material_of
from scipy.linalg import solveh_banded

from martensite.export.ports.umat import write_umat
from martensite.kernels.compiler import find_compiler
from martensite.physics.laws.base import LAWS

pytestmark = pytest.mark.usefixtures("c_compiler")

WARM = 335.0
COUNT = 100
LENGTH = 100.0
"""[mm]"""


class Bar:
    """Elements in a row, from a wall to an end that is moved; each with its own section and temperature."""

    def __init__(self, host: UmatHost, sections: Any, offsets: Any) -> None:
        self.host, self.sections, self.offsets = host, sections, offsets
        self.count, self.size = len(sections), LENGTH / len(sections)
        self.moved = np.zeros(self.count + 1)
        self.states = [np.zeros(host.states) for _ in sections]
        self.temperature = WARM - ZERO
        self.residuals: list[float] = []

    def _respond(self, moved: Any, warming: float) -> tuple[Any, Any, list[Any]]:
        """Forces [N], stiffnesses [N/mm] and state variables."""
        old, change = np.diff(self.moved) / self.size, np.diff(moved - self.moved) / self.size
        rows = [
            self.host.call(state, [before], [more], self.temperature + offset, warming, 1.0)
            for state, before, more, offset in zip(self.states, old, change, self.offsets, strict=True)
        ]
        stress, tangent = np.array([r[0][0] for r in rows]), np.array([r[1][0, 0] for r in rows])
        return stress * self.sections, tangent * self.sections / self.size, [r[2] for r in rows]

    def step(self, end: float, warming: float) -> float:
        """Force [N] after an increment; the residuals of its iterations are kept."""
        moved, self.residuals = self.moved.copy(), []
        moved[-1] = end
        moved[1:-1] += np.linspace(0.0, end - self.moved[-1], self.count + 1)[1:-1]
        forces, stiff, states = self._respond(moved, warming)
        for _ in range(30):
            out = forces[:-1] - forces[1:]
            self.residuals.append(float(np.linalg.norm(out)))
            if self.residuals[-1] < 1e-9 * max(float(np.max(np.abs(forces))), 1.0):
                self.moved, self.states, self.temperature = moved, states, self.temperature + warming
                return float(forces[-1])
            band = np.vstack([np.r_[0.0, -stiff[1:-1]], stiff[:-1] + stiff[1:]])
            correction = np.r_[0.0, solveh_banded(band, out), 0.0]
            share, found = 1.0, (forces, stiff, states)
            for share in 0.5 ** np.arange(12):  # where an element turns round, its stiffness is another one
                found = self._respond(moved - share * correction, warming)
                if np.linalg.norm(np.diff(found[0])) < (1.0 - 1e-3 * share) * self.residuals[-1]:
                    break
            moved, (forces, stiff, states) = moved - share * correction, found
        raise AssertionError(f"Newton's method did not converge: {self.residuals}")


COURSE = [
    *((float(end), 0.0) for end in (*np.linspace(0.0, 4.0, 21)[1:], *np.linspace(4.0, 1.5, 14)[1:])),
    *((1.5, warming) for warming in (*[4.0] * 5, *[-4.0] * 9)),
]
"""A superelastic loop, then a thermal cycle at a held elongation: elongation [mm] and warming [K]."""


def walk(bar: Bar) -> list[float]:
    """Forces [N] along the course."""
    return [bar.step(end, warming) for end, warming in COURSE]


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> UmatHost:
    return UmatHost(tmp_path_factory.mktemp("umat"), material_of(example(LAWS["brinson"])))


def test_newton_converges_in_the_second_order(host: UmatHost) -> None:
    """In a bar that is thicker and warmer towards its end: near a solution a residual is as the square of the last."""
    share, pairs = np.linspace(0.0, 1.0, COUNT), []
    bar = Bar(host, 0.785 * (1.0 + 0.005 * share), 0.3 * share)
    forces = []
    for end, warming in COURSE:
        forces.append(bar.step(end, warming))
        assert len(bar.residuals) <= 8
        found = bar.residuals
        pairs += [(a, b) for a, b in itertools.pairwise(found) if a < 0.05 and b > 1e-10]
    assert max(forces) > 300.0 and len(pairs) > 50
    assert max(b / a**2 for a, b in pairs) < 10.0


def test_equal_elements_are_one(host: UmatHost) -> None:
    one = walk(Bar(host, np.array([0.785]), np.zeros(1)))
    many = walk(Bar(host, np.full(COUNT, 0.785), np.zeros(COUNT)))
    np.testing.assert_allclose(many, one, rtol=1e-8)
    kernel = host.kernel
    now, size, forces = kernel.functions["init"](0.0, WARM), kernel.size, []
    for end in np.linspace(0.0, 4.0, 21)[1:]:
        found, _ = kernel.try_step(now, (end / LENGTH, WARM), 1.0)
        now = found[:size]
        forces.append(0.785e-6 * found[size + 2])
    np.testing.assert_allclose(one[:20], forces, rtol=1e-12)


def test_fibres_in_solids(host: UmatHost) -> None:
    """Six components: the first is that of a truss, the others are elastic and do not touch it."""
    solid, truss = copy.copy(host), copy.copy(host)
    solid.components, solid.props = 6, [1e6, ZERO, 7000.0, WARM - ZERO]
    change = np.array([0.02, 1e-3, -2e-3, 4e-3, 0.0, 1e-3])
    args = (WARM - ZERO, 0.0, 1.0)
    stress, tangent, state = solid.call(np.zeros(solid.states), np.zeros(6), change, *args)
    alone, slope, same = truss.call(np.zeros(truss.states), [0.0], [0.02], *args)
    np.testing.assert_array_equal(stress, [alone[0], 7.0, -14.0, 14.0, 0.0, 3.5])
    np.testing.assert_array_equal(np.diag(tangent), [slope[0, 0], 7e3, 7e3, 3.5e3, 3.5e3, 3.5e3])
    np.testing.assert_array_equal(state, same)
    assert np.count_nonzero(tangent) == 6
    truss.props = [
        1e6,
        ZERO,
        0.0,
        WARM - ZERO,
        *[truss.kernel.values[i] for i in truss.kernel.write_core().parameter_indices],
    ]
    failed, *_ = truss.call(np.zeros(truss.states), [0.0], [math.nan], *args)
    assert np.isnan(failed).all() and truss.answer["pnewdt"] == 0.5  # a host that does not look cannot go on
    again, *_ = truss.call(np.zeros(truss.states), [0.0], [0.02], *args)
    np.testing.assert_array_equal(again, alone)


def _write_deck(count: int, states: int) -> str:
    """A bar of solids along x: a superelastic loop, and a thermal cycle at a held elongation."""
    side, faces = 0.785**0.5, range(count + 1)
    corners = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side))
    nodes = [
        f"{4 * i + j + 1},{LENGTH * i / count:.10g},{y:.12g},{z:.12g}"
        for i in faces
        for j, (y, z) in enumerate(corners)
    ]
    solids = [f"{i + 1}," + ",".join(str(4 * i + j + 1) for j in range(8)) for i in range(count)]
    sets = {
        "LEFT": [1, 2, 3, 4],
        "RIGHT": [4 * count + j + 1 for j in range(4)],
        "YZERO": [4 * i + j for i in faces for j in (1, 4)],
        "ZZERO": [4 * i + j for i in faces for j in (1, 2)],
        "ALL": range(1, 4 * count + 5),
    }
    named = [f"*NSET,NSET={name}\n" + "\n".join(map(str, ids)) for name, ids in sets.items()]
    start = WARM - ZERO
    steps = [
        f"*STEP,INC=100\n*STATIC,DIRECT\n{size},1.\n*BOUNDARY\nRIGHT,1,1,{end}\n*TEMPERATURE\nALL,{start + warming}\n"
        "*NODE PRINT,NSET=RIGHT,TOTALS=ONLY\nRF\n*END STEP"
        for end, warming, size in ((4.0, 0.0, 0.05), (1.5, 0.0, 1 / 13), (1.5, 20.0, 0.2), (1.5, -16.0, 1 / 9))
    ]
    rest = (
        f"*MATERIAL,NAME=@ABAQUS_SMA\n*DEPVAR\n{states}\n*USER MATERIAL,CONSTANTS=4\n1.E6,{ZERO},0.,{start}\n"
        "*SOLID SECTION,ELSET=BAR,MATERIAL=@ABAQUS_SMA\n*INITIAL CONDITIONS,TYPE=TEMPERATURE\n"
        f"ALL,{start}\n*BOUNDARY\nLEFT,1,1\nYZERO,2,2\nZZERO,3,3"
    )
    return "\n".join(["*NODE", *nodes, "*ELEMENT,TYPE=C3D8,ELSET=BAR", *solids, *named, rest, *steps]) + "\n"


def _find_calculix() -> str:
    found = shutil.which("ccx")
    if found is None:
        pytest.skip("no CalculiX on this machine (ccx)")
    if b"dlopen" not in Path(found).read_bytes():
        pytest.skip("this ccx was built without external behaviours: it loads no library of a material")
    return found


@pytest.mark.parametrize("count", [1, COUNT])
def test_calculix(count: int, host: UmatHost, tmp_path: Path) -> None:
    ccx = _find_calculix()
    (tmp_path / "sma_umat.c").write_text(write_umat(host.kernel, "sma")["_umat.c"])
    command = [str(find_compiler()), "-std=c99", "-O1", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([*command, "-o", "libSMA.so", "sma_umat.c", "-lm"], cwd=tmp_path, check=True)
    (tmp_path / "bar.inp").write_text(_write_deck(count, host.states))
    around = {**os.environ, "LD_LIBRARY_PATH": str(tmp_path), "OMP_NUM_THREADS": "1"}
    done = subprocess.run([ccx, "bar"], cwd=tmp_path, env=around, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout[-2000:]
    rows = re.findall(r"total force .*\n\n\s+(\S+)", (tmp_path / "bar.dat").read_text())
    expected = walk(Bar(host, np.array([0.785]), np.zeros(1)))
    np.testing.assert_allclose([float(row) for row in rows], expected, rtol=2e-6, atol=2e-4)
    increments = len(expected)
    assert done.stdout.count("iteration ") <= 3 * increments
