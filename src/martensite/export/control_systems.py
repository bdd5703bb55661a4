"""Models of blocks for python-control: the model itself, and its linear system.

The model is a `NonlinearIOSystem` in discrete time with the state of the chain, so that it can
be put in a loop with whatever python-control offers; the linear system is a `StateSpace`, for
Bode and Nyquist plots, margins and pole placement.

python-control comes with `pip install martensite[control]`.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from martensite.errors import InputError
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.linear_system import Linear
from martensite.identify.chains.linearise import linearise


def to_control(chain: Chain) -> Any:
    """The chain as a `control.NonlinearIOSystem` with its sample time as `dt`.

    States are called after their block: `1.x1`, `1.x2`, …; python-control takes dots in names.
    The state at rest under an input is that of `operating_point`.

    Raises:
        InputError: python-control is not installed.
    """
    control = _control()
    step = _Step(chain)
    return control.NonlinearIOSystem(
        step.update, step.output, inputs=list(chain.input_names), outputs=list(chain.output_names),
        states=step.names, dt=chain.interval, name=_name(chain.name),
    )  # fmt: skip


def to_state_space(system: Chain | Linear, level: Any = 0.0) -> Any:
    """A linear system as a `control.StateSpace`, without states that take no part.

    Args:
        system: a linear system, or a chain that is linearised at rest.
        level: the input at which a chain is linearised, one number or one for each input.

    Raises:
        InputError: python-control is not installed, or the level does not fit.
    """
    control = _control()
    linear = system if isinstance(system, Linear) else linearise(system, level)
    slim = linear.reduced()
    return control.ss(
        slim.a, slim.b, slim.c, slim.d, slim.interval,
        inputs=list(slim.input_names) or None, outputs=list(slim.output_names) or None,
    )  # fmt: skip


class _Step:
    """One sample of a chain, as python-control calls it."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.names = [
            f"{k}.x{i}"
            for k, block in enumerate(chain.blocks, start=1)
            for i in range(1, block.states() + 1)
        ]

    def _run(self, x: Any, u: Any) -> tuple[Any, Any]:
        state = np.array(x, dtype=float)
        row = np.asarray(u, dtype=float).reshape(1, -1)
        y = self.chain.engine.simulate(self.chain.theta, row, state)
        return y[0], state

    def update(self, time: float, x: Any, u: Any, parameters: Any) -> Any:
        """The state for the next sample."""
        return self._run(x, u)[1]

    def output(self, time: float, x: Any, u: Any, parameters: Any) -> Any:
        """The outputs of this sample."""
        return self._run(x, u)[0]


def _name(text: str) -> str:
    """A name that python-control takes: it refuses dots."""
    return text.replace(".", "_")


def _control() -> Any:
    try:
        return import_module("control")
    except ImportError:
        raise InputError(
            "This needs python-control, which is not installed; "
            "run `pip install martensite[control]`."
        ) from None
