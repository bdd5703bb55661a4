"""Models, plants and benches for python-control: the nonlinear system, and its linearisation.

A model of blocks, a plant or a bench becomes a `NonlinearIOSystem` in discrete time; its linearisation is a
`StateSpace`.

A plant has hysteresis, so its linearisation holds on one branch only. For `control.linearize`, use a signal slightly
above the operating point for the heating branch, and slightly below for the cooling branch. Readings of a bench at the
end of a period, such as the reference of its controller, are one sample earlier here than in `simulate`.

python-control comes with `pip install 'martensite[control]'`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, require_known
from martensite.base.lazy import import_extra
from martensite.control.loop.names import JITTER, NOISE
from martensite.control.synthesis.linear import linearise_plant
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.linear_system import LinearSystem
from martensite.identify.chains.linearise import linearise_chain
from martensite.kernels import floats
from martensite.simulate.api import steps_in
from martensite.simulate.compiled import bind_system
from martensite.simulate.operating_point import SteadyPoint


def to_control(chain: Chain) -> Any:
    """Return a chain as a `control.NonlinearIOSystem` with its sample time as `dt`.

    States are named after their block: `1.x1`, `1.x2`, …

    Raises:
        InputError: python-control is not installed.
    """
    control = import_extra("control", "control", "python-control")
    step = _Step(chain)
    return control.NonlinearIOSystem(
        step.update,
        step.output,
        inputs=list(chain.input_names),
        outputs=list(chain.output_names),
        states=step.names,
        dt=chain.interval,
        name=_remove_dots(chain.name),
    )


def to_state_space(system: Chain | LinearSystem, level: Any = 0.0) -> Any:
    """Return a linear system as a minimal `control.StateSpace`.

    Args:
        system: a linear system, or a chain that is linearised at steady state.
        level: input level of the linearisation, one value or one per input.

    Raises:
        InputError: python-control is not installed, the level does not fit, or it is an actuator.
    """
    if isinstance(system, AbstractSystem):
        raise InputError("`to_state_space` takes a chain or a linear system; give an actuator to `plant_state_space`.")
    control = import_extra("control", "control", "python-control")
    linear = system if isinstance(system, LinearSystem) else linearise_chain(system, level)
    slim = linear.reduce_states()
    return control.ss(
        slim.a,
        slim.b,
        slim.c,
        slim.d,
        slim.interval,
        inputs=list(slim.input_names) or None,
        outputs=list(slim.output_names) or None,
    )


def to_nonlinear_system(
    system: AbstractSystem, period: float | None = None, *, outputs: Sequence[str] | None = None
) -> Any:
    """Return a plant or a bench as a `control.NonlinearIOSystem` in discrete time.

    Inputs are its drives, without noise and jitter of sensors. Dots in names become underscores. For its steady state
    see `compute_rest_state`.

    Args:
        system: a plant, or a bench with its sample time.
        period: sample time of a plant [s].
        outputs: names of outputs; by default all.

    Raises:
        InputError: python-control is not installed, a name is unknown, or the period is missing.
    """
    control = import_extra("control", "control", "python-control")
    step = _PlantStep(system, period, outputs)
    return control.nlsys(
        step.update,
        step.output,
        inputs=[_remove_dots(n) for n in step.inputs],
        outputs=[_remove_dots(n) for n in step.outputs],
        states=step.names,
        dt=step.interval,
        name=_remove_dots(type(system).__name__.lower()),
    )


def compute_rest_state(system: AbstractSystem, signals: Sequence[float] = ()) -> Any:
    """Return the flat steady state of a plant or bench, as used by `to_nonlinear_system`.

    Args:
        system: the plant, or the bench.
        signals: signals of the first drives; others are 0.
    """
    drives = len(system.drives())
    first = [*map(float, signals), *[0.0] * (drives - len(signals))][:drives]
    functions, _ = bind_system(system)
    return np.array(functions["init"](*first))


def plant_state_space(
    point: SteadyPoint,
    period: float | None = None,
    *,
    outputs: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
) -> Any:
    """Return the minimal linearisation of a plant on the branch of an operating point, as a `StateSpace`.

    Args:
        point: operating point with its history.
        period: sample time [s] of a plant in continuous time.
        outputs: names of outputs; by default all.
        inputs: names of drives; by default the varied drive.

    Raises:
        InputError: python-control is not installed, or a name is unknown.
    """
    control = import_extra("control", "control", "python-control")
    linear = linearise_plant(point, period, inputs=inputs)
    chosen = _choose_names(outputs, linear.output_names)
    rows = [linear.output_names.index(name) for name in chosen]
    names, active = state_names(point.system), linear.active
    return control.ss(
        linear.a[active][:, active],
        linear.b[active],
        linear.c[rows][:, active],
        linear.d[rows],
        linear.interval,
        inputs=[_remove_dots(n) for n in linear.input_names],
        outputs=[_remove_dots(n) for n in chosen],
        states=[names[k] for k in active],
    )


def state_names(system: AbstractSystem) -> list[str]:
    """Return the names of the flat state of a system: `elements0_memory_temperature`."""
    state = system.init(floats, *[0.0] * len(system.drives()))
    return [name or "state" for name in _walk_numbers("", state)]


def _walk_numbers(name: str, nested: Any) -> Iterator[str]:
    if not isinstance(nested, tuple):
        yield name
        return
    fields: Any = getattr(type(nested), "_fields", None)  # type: ignore[arg-type]
    for k, item in enumerate(nested):  # type: ignore[arg-type]
        inner = f"{name}_{fields[k]}" if fields else f"{name}{k}"
        yield from _walk_numbers(inner.removeprefix("_"), item)


def _choose_names(wanted: Sequence[str] | None, valid: Sequence[str]) -> list[str]:
    for name in wanted or ():
        require_known("output", name, valid)
    return list(wanted or valid)


class _PlantStep:
    """One period of a plant, in the interface of python-control."""

    def __init__(self, system: AbstractSystem, period: float | None, outputs: Sequence[str] | None) -> None:
        own = system.sample_time()
        interval = own or period
        if not interval or interval <= 0.0:
            raise InputError("A plant in continuous time needs a `period` above 0 s.")
        drives = [drive.name for drive in system.drives()]
        self.interval: float = interval
        self.inputs = [name for name in drives if not name.startswith((NOISE, JITTER))]
        self.outputs = _choose_names(outputs, list(system.outputs()))
        self.names = state_names(system)
        self._drive_indices = [drives.index(name) for name in self.inputs]
        self._list_extras = [list(system.outputs()).index(name) for name in self.outputs]
        self._functions, self._size = bind_system(system)
        self._idle = [0.0] * len(drives)
        self._turns = 1 if own else steps_in(system, interval)

    def _signals(self, u: Any) -> list[float]:
        signals = list(self._idle)
        for place, value in zip(self._drive_indices, np.atleast_1d(u).tolist(), strict=True):
            signals[place] = value
        return signals

    def update(self, time: float, x: Any, u: Any, parameters: Any) -> Any:
        """Return the state after a period."""
        state, signals = tuple(np.asarray(x, dtype=float).tolist()), self._signals(u)
        for _ in range(self._turns):
            results = self._functions["step"](*state, *signals, self.interval / self._turns)
            state = results[: self._size]
        return np.array(state)

    def output(self, time: float, x: Any, u: Any, parameters: Any) -> Any:
        """Return the outputs of a state under signals."""
        state = np.asarray(x, dtype=float).tolist()
        outputs = self._functions["observe"](*state, *self._signals(u))
        return np.array([outputs[k] for k in self._list_extras])


class _Step:
    """One sample of a chain, in the interface of python-control."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.names = [
            f"{k}.x{i}" for k, block in enumerate(chain.blocks, start=1) for i in range(1, block.states() + 1)
        ]

    def _run(self, x: Any, u: Any) -> tuple[Any, Any]:
        state = np.array(x, dtype=float)
        row = np.asarray(u, dtype=float).reshape(1, -1)
        y = self.chain.engine.simulate(self.chain.theta, row, state)
        return y[0], state

    def update(self, time: float, x: Any, u: Any, parameters: Any) -> Any:
        """Return the state at the next sample."""
        return self._run(x, u)[1]

    def output(self, time: float, x: Any, u: Any, parameters: Any) -> Any:
        """Return the outputs of this sample."""
        return self._run(x, u)[0]


def _remove_dots(text: str) -> str:
    """Return a name without dots, which python-control refuses."""
    return text.replace(".", "_")
