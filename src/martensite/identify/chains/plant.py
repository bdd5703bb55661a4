"""Models of blocks as plants: driven by the library's own waveforms and controllers.

A model is a mechanism without elements. Its signals are the inputs of the model, its outputs the outputs of the model.
So a model runs like any system: under `simulate`, in `simulate_controlled`, from a scenario. It is defined at its
samples alone: runs go from sample to sample, inputs are held from the start of a sample, and accuracy is not estimated.

Inside the library all numbers are in SI; the plant converts from there to the units of the model
and back. Unknown units and missing units are left as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np

from martensite.actuators.assembly import Machine
from martensite.actuators.elements.base import AbstractElement
from martensite.actuators.mechanisms.base import AbstractMechanism, Column, Load, Output
from martensite.base import units
from martensite.base.errors import InputError, UnitError
from martensite.base.parameters import REQUIRED, Declared
from martensite.identify.blocks.base import AbstractBlock
from martensite.identify.chains.chain import Chain
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport

SI = (
    "1",
    "K",
    "m",
    "s",
    "N",
    "Pa",
    "V",
    "A",
    "W",
    "ohm",
    "rad",
    "rad/s",
    "m/s",
    "N*m",
    "Hz",
    "kg",
    "J/kg",
    "m/s^2",
    "N/m",
)
"""Units that signals are read as, if theirs can be converted to one of them."""


def build_plant(chain: Chain) -> Machine:
    """Return a chain as a system: its drives are called after its inputs, its outputs after its outputs.

    Raises:
        InputError: an input and an output have the same name.
    """
    return Machine(mechanism=ModelMechanism(chain))


class ModelMechanism(AbstractMechanism):
    """A chain as a mechanism without ports. Its numbers are those of the chain."""

    registered_name = "model"

    def __init__(self, chain: Chain) -> None:
        both = set(chain.input_names) & set(chain.output_names)
        if both:
            raise InputError(
                f"Model `{chain.name}` has inputs and outputs of the same name: "
                f"{', '.join(sorted(both))}; rename one of them."
            )
        self.__dict__["chain"] = chain
        self.__dict__["registered_name"] = f"model {chain.name}"
        self.__dict__["structure"] = (
            tuple(block.structure() for block in chain.blocks),
            chain.engine.taps,
            chain.interval,
            tuple(chain.input_names),
            tuple(chain.output_names),
            tuple(sorted(chain.units.items())),
        )
        for name, value in zip(_list_paths(chain), _list_values(chain), strict=True):
            self.__dict__[name] = value

    @property
    def declarations(self) -> dict[str, Declared]:  # type: ignore[override]
        """Return one parameter per free or fixed number, and the structure as an option."""
        chain: Chain = self.__dict__["chain"]
        found = {name: Declared("parameter", "number of a block", REQUIRED) for name in _list_paths(chain)}
        return {"structure": Declared("option", "blocks and signals", REQUIRED), **found}

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that make an equal object: the chain."""
        return {"chain": self.model}

    def _with_paths(self, values: Mapping[str, Any]) -> Self:
        """Return a checked copy with some numbers changed."""
        own = {**{name: self.__dict__[name] for name in _list_paths(self.model)}, **values}
        blocks = tuple(
            block.with_given([float(own[f"b{k}_{name}"]) for name in block.fixed])
            for k, block in enumerate(self.model.blocks, start=1)
        )
        theta = [float(own[f"b{k}_{name}"]) for k, block in enumerate(blocks, start=1) for name in block.numbers()]
        return type(self)(replace(self.model, blocks=blocks, theta=np.array(theta)))

    @property
    def model(self) -> Chain:
        """Return the chain, with the numbers that it was made of."""
        return self.__dict__["chain"]

    def ports(self) -> tuple[str, ...]:
        """None: a model needs no element."""
        return ()

    def sample_time(self) -> float:
        """Return the sample time of the chain [s]."""
        return self.model.interval

    def first_step(self) -> float:
        """Return the sample time [s]."""
        return self.model.interval

    def signals(self) -> dict[str, str]:
        """Return the inputs with their SI units."""
        return {name: _find_conversion(self.model, name)[0] for name in self.model.input_names}

    def outputs(self) -> dict[str, Output]:
        """Return the outputs with their SI units."""
        return {
            name: Output(_find_conversion(self.model, name)[0], name.replace("_", " "), "y")
            for name in self.model.output_names
        }

    def convergence_scales(self) -> dict[str, float]:
        """Return all outputs."""
        return dict.fromkeys(self.model.output_names, 1e-9)

    def start_forces(self, xp: Namespace) -> Column:
        """None."""
        return ()

    def init(self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column) -> Any:
        """Return the state at rest under the first inputs, block by block."""
        x, found = self.convert_inputs(signals), []
        for block, theta in self._blocks():
            state = block.rest(xp, theta, x, self.model.interval)
            x, _ = block.step(xp, theta, state, x, self.model.interval)
            found.append(tuple(state))
        return tuple(found)

    def advance(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Any, list[Any], StepReport]:
        """Return the state one sample on, whatever `dt`."""
        after, _ = self._sample(xp, memory, signals)
        return after, [], StepReport(0.0, 0.0)

    def observe(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """Return the outputs of this sample."""
        return [], self._sample(xp, memory, signals)[1]

    def _sample(self, xp: Namespace, memory: Any, signals: Column) -> tuple[Any, list[Scalar]]:
        x = self.convert_inputs(signals)
        after: list[Any] = []
        signals_of: list[Column] = []
        for (block, theta), state in zip(self._blocks(), memory, strict=True):
            x, then = block.step(xp, theta, state, x, self.model.interval)
            after.append(tuple(then))
            signals_of.append(x)
        seen = [signals_of[k][i] for k, i in self.model.engine.taps]
        return tuple(after), self._outside(seen)

    def _blocks(self) -> list[tuple[AbstractBlock, Column]]:
        """Return the blocks with the numbers of this mechanism, which may be traced."""
        found: list[tuple[AbstractBlock, Column]] = []
        for k, block in enumerate(self.model.blocks, start=1):
            given = [self.__dict__[f"b{k}_{name}"] for name in block.fixed]
            theta = [self.__dict__[f"b{k}_{name}"] for name in block.numbers()]
            found.append((block.with_given(given), theta))
        return found

    def convert_inputs(self, signals: Column) -> list[Scalar]:
        """Return the inputs in SI in the units of the model."""
        kinds = [_find_conversion(self.model, name) for name in self.model.input_names]
        return [(u - offset) * (1.0 / factor) for u, (_, factor, offset) in zip(signals, kinds, strict=True)]

    def _outside(self, outputs: Sequence[Scalar]) -> list[Scalar]:
        """Return the outputs in the units of the model in SI."""
        kinds = [_find_conversion(self.model, name) for name in self.model.output_names]
        return [y * factor + offset for y, (_, factor, offset) in zip(outputs, kinds, strict=True)]


def _list_paths(chain: Chain) -> list[str]:
    """Return the names of all fixed and free numbers, with the number of their block."""
    return [
        f"b{k}_{name}" for k, block in enumerate(chain.blocks, start=1) for name in (*block.fixed, *block.numbers())
    ]


def _list_values(chain: Chain) -> list[float]:
    return [
        float(value)
        for block, theta in zip(chain.blocks, chain.split(), strict=True)
        for value in (*block.given(), *theta)
    ]


def _find_conversion(chain: Chain, name: str) -> tuple[str, float, float]:
    """SI unit of a signal, and the factor and offset that lead to it."""
    spelling = chain.units.get(name, "1") or "1"
    for unit in SI:
        try:
            return unit, *units.find_conversion(spelling, unit)
        except UnitError:
            continue
    return spelling, 1.0, 0.0
