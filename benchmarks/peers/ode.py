"""Library ODE solvers on the rate form R of problem A: SciPy and SUNDIALS CVODE (scikit-sundae).

What: beside `solve_ivp` stands `odeint`, which runs LSODA without a Python loop around each step,
and both `odeint` and CVODE once more with a right-hand side compiled by numba, where installed.
The solvers look for no edges of the input: with
`pieces=True` (the usual setting here) they are restarted at every edge; without it they step
over pulses in silence, whatever the tolerance, unless `max_step` is shorter than the pulses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from benchmarks.engines import Engine
from benchmarks.inputs import Drive
from benchmarks.objective import differences
from benchmarks.peers.rate_form import make_compiled_rhs, make_rates, make_rhs
from benchmarks.problem_a import Wire, displacement, lumped, one_set, scaled


class Setting(NamedTuple):
    """Tolerances of an ODE solver; atol of (T, xi) is (10, 0.1) rtol."""

    rtol: float
    max_step: float = 0.5  # [s]
    pieces: bool = True
    beyond: bool = False  # see `rate_form`


TOLERANCES = {f"rtol 1e-{k}": Setting(10.0**-k) for k in range(3, 10)}
BEYOND = {label: s._replace(beyond=True) for label, s in TOLERANCES.items()}
UNAWARE = {label: s._replace(pieces=False) for label, s in TOLERANCES.items()}
TIGHT = Setting(1e-11, 5e-3)


def spans(drive: Drive, setting: Setting, grid: Any) -> Iterator[tuple[Any, Any]]:
    """(output times with both ends, mask of those on the grid), one pair per restart."""
    import numpy

    inner = [t for t in drive.edges if 0 < t < drive.duration] if setting.pieces else []
    for a, b in zip([0.0, *inner], [*inner, drive.duration], strict=True):
        times = grid[(grid > a + 1e-9) & (grid < b - 1e-9)]
        ends = numpy.concatenate(([a], times, [b]))
        yield ends, numpy.isclose(ends, numpy.round(ends * 10) / 10, rtol=0, atol=1e-9)


def by_odeint(rhs: Any, y: Any, times: Any, s: Setting, atol: list[float]) -> Any:
    """States at `times` by LSODA through `scipy.integrate.odeint`."""
    from scipy.integrate import odeint

    more = {"hmax": s.max_step, "mxstep": 100_000_000, "tfirst": True}
    return odeint(rhs, y, times, rtol=s.rtol, atol=atol, **more)


def by_solve_ivp(method: str) -> Callable[..., Any]:
    """States at `times` by a method of `scipy.integrate.solve_ivp`."""

    def solve(rhs: Any, y: Any, times: Any, s: Setting, atol: list[float]) -> Any:
        from scipy.integrate import solve_ivp

        more = {"method": method, "max_step": s.max_step, "rtol": s.rtol, "atol": atol}
        return solve_ivp(rhs, (times[0], times[-1]), y, t_eval=times, **more).y.T

    return solve


def by_cvode(rhs: Any, y: Any, times: Any, s: Setting, atol: list[float]) -> Any:
    """States at `times` by SUNDIALS CVODE (BDF)."""
    import numpy
    from sksundae.cvode import CVODE

    def fill(t: float, y: Any, yp: Any) -> None:
        yp[:] = rhs(t, y)

    more = {"method": "BDF", "max_step": s.max_step, "max_num_steps": 10_000_000}
    solver = CVODE(fill, rtol=s.rtol, atol=numpy.array(atol), **more)
    if len(times) > 2:
        return solver.solve(times, y).y
    return solver.solve(times, y).y[[0, -1]]  # two times ask CVODE for its own steps


def trajectory(solve: Any, rhs: Any, p: Wire, drive: Drive, s: Setting) -> Any:
    """States (T, xi) on the output grid, shape (outputs, 2)."""
    import numpy

    grid = numpy.arange(round(drive.duration * 10) + 1) / 10
    y, parts = numpy.array([p.T_a, 1.0]), []
    for times, on_grid in spans(drive, s, grid):
        states = solve(rhs, y, times, s, [10 * s.rtol, 0.1 * s.rtol])
        if len(states) < len(times):  # the solver gave up
            return numpy.full((len(grid), 2), numpy.nan)
        y = states[-1].copy()
        parts.append(states[:-1][on_grid[:-1]])
    return numpy.concatenate([*parts, y[None]])


def record(solve: Any, p: Wire, drive: Drive, s: Setting) -> Any:
    """x [mm] on the output grid, right-hand side in Python."""
    rhs = make_rhs(p, drive, s.beyond)
    return displacement(p, lumped(p), *trajectory(solve, rhs, p, drive, s).T)


def engine(
    name: str, solve: Any, settings: dict[str, Any], usual: str, only_single: bool = False, needs: str = ""
) -> Engine:
    """The record of one solver."""
    nb = needs == "numba"
    make = make_compiled_rhs if nb else make_rhs

    def single(p: Wire, drive: Drive, s: Setting) -> Callable[[], Any]:
        rhs, d = make(p, drive, s.beyond), lumped(p)
        return lambda: displacement(p, d, *trajectory(solve, rhs, p, drive, s).T)

    def batch(sets: Wire, drive: Drive, s: Setting) -> Callable[[], list[Any]]:
        runs = [single(one_set(sets, i), drive, s) for i in range(len(sets.h0))]
        return lambda: [run() for run in runs]

    def gradient(p: Wire, drive: Drive, s: Setting) -> Callable[[], list[float]]:
        return differences(lambda q: single(scaled(p, q), drive, s)().tolist(), h=1e-3)

    def control_step(p: Wire, dt: float) -> Any:
        import numpy

        rates, s = make_rates(p), Setting(1e-6)
        times, atol = numpy.array([0.0, dt]), [10 * s.rtol, 0.1 * s.rtol]

        def advance(y: Any, U: float) -> Any:
            def rhs(t: float, y: Any) -> tuple[float, float]:
                T, xi = y.tolist()
                return rates(T, xi, U)

            return solve(rhs, y, times, s, atol)[-1]

        return numpy.array([p.T_a, 1.0]), advance

    return Engine(
        name=name,
        rule="R",
        settings=settings,
        usual=usual,
        single=single,
        batch=None if only_single else batch,
        gradient=None if only_single or nb else gradient,
        step=None if only_single or nb else control_step,
        batch_limit=8,
        only_edges=settings is UNAWARE or settings is BEYOND,
        optional=needs,
    )


ENGINES = (
    engine("odeint", by_odeint, TOLERANCES, "rtol 1e-6"),
    engine("odeint-beyond", by_odeint, BEYOND, "rtol 1e-6", only_single=True),
    engine("odeint-unaware", by_odeint, UNAWARE, "rtol 1e-6", only_single=True),
    engine("lsoda", by_solve_ivp("LSODA"), TOLERANCES, "rtol 1e-6"),
    engine("rk45", by_solve_ivp("RK45"), TOLERANCES, "rtol 1e-7", only_single=True),
    engine("dop853", by_solve_ivp("DOP853"), TOLERANCES, "rtol 1e-6", only_single=True),
    engine("radau", by_solve_ivp("Radau"), TOLERANCES, "rtol 1e-5", only_single=True),
    engine("cvode", by_cvode, TOLERANCES, "rtol 1e-6", needs="sksundae"),
    engine("odeint-numba", by_odeint, TOLERANCES, "rtol 1e-6", needs="numba"),
    engine("cvode-numba", by_cvode, TOLERANCES, "rtol 1e-6", needs="numba"),
)
