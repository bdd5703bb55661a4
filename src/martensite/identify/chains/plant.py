"""Models of blocks as plants, driven by waveforms and controllers.

A model is a mechanism without elements: its signals are the inputs of the model. It runs like any system in `simulate`,
`simulate_controlled` and scenarios, from sample to sample with held inputs and without an estimate of the accuracy. The
plant converts between SI and the units of the model; unknown units are not converted.
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
from martensite.base.parameters import REQUIRED, FieldDeclaration
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
"""Units of signals, if theirs can be converted."""


def build_plant(chain: Chain) -> Machine:
    """Return a chain as a system with its input and output names.

    Raises:
        InputError: an input and an output have the same name.
    """
    return Machine(mechanism=ModelMechanism(chain))


class ModelMechanism(AbstractMechanism):
    """A chain as a mechanism without ports."""

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
    def declarations(self) -> dict[str, FieldDeclaration]:  # type: ignore[override]
        chain: Chain = self.__dict__["chain"]
        numbers = {name: FieldDeclaration("parameter", "number of a block", REQUIRED) for name in _list_paths(chain)}
        return {"structure": FieldDeclaration("option", "blocks and signals", REQUIRED), **numbers}

    def arguments(self) -> dict[str, Any]:
        return {"chain": self.model}

    def _with_paths(self, values: Mapping[str, Any]) -> Self:
        all_values = {**{name: self.__dict__[name] for name in _list_paths(self.model)}, **values}
        blocks = tuple(
            block.with_fixed_values([float(all_values[f"b{k}_{name}"]) for name in block.fixed])
            for k, block in enumerate(self.model.blocks, start=1)
        )
        theta = [
            float(all_values[f"b{k}_{name}"]) for k, block in enumerate(blocks, start=1) for name in block.numbers()
        ]
        return type(self)(replace(self.model, blocks=blocks, theta=np.array(theta)))

    @property
    def model(self) -> Chain:
        """Return the chain with its original numbers."""
        return self.__dict__["chain"]

    def ports(self) -> tuple[str, ...]:
        return ()

    def sample_time(self) -> float:
        return self.model.interval

    def first_step(self) -> float:
        return self.model.interval

    def signals(self) -> dict[str, str]:
        return {name: _find_conversion(self.model, name)[0] for name in self.model.input_names}

    def outputs(self) -> dict[str, Output]:
        return {
            name: Output(_find_conversion(self.model, name)[0], name.replace("_", " "), "y")
            for name in self.model.output_names
        }

    def convergence_scales(self) -> dict[str, float]:
        return dict.fromkeys(self.model.output_names, 1e-9)

    def start_forces(self, xp: Namespace) -> Column:
        return ()

    def init(self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column) -> Any:
        x, states = self.convert_inputs(signals), []
        for block, theta in self._blocks():
            state = block.rest(xp, theta, x, self.model.interval)
            x, _ = block.step(xp, theta, state, x, self.model.interval)
            states.append(tuple(state))
        return tuple(states)

    def advance(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Any, list[Any], StepReport]:
        after, _ = self._sample(xp, memory, signals)
        return after, [], StepReport(0.0, 0.0)

    def observe(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        return [], self._sample(xp, memory, signals)[1]

    def _sample(self, xp: Namespace, memory: Any, signals: Column) -> tuple[Any, list[Scalar]]:
        x = self.convert_inputs(signals)
        after: list[Any] = []
        signals_of: list[Column] = []
        for (block, theta), state in zip(self._blocks(), memory, strict=True):
            x, then = block.step(xp, theta, state, x, self.model.interval)
            after.append(tuple(then))
            signals_of.append(x)
        outputs = [signals_of[k][i] for k, i in self.model.engine.taps]
        return tuple(after), self._outside(outputs)

    def _blocks(self) -> list[tuple[AbstractBlock, Column]]:
        """Return the blocks with the numbers of this mechanism, which may be traced."""
        blocks: list[tuple[AbstractBlock, Column]] = []
        for k, block in enumerate(self.model.blocks, start=1):
            given = [self.__dict__[f"b{k}_{name}"] for name in block.fixed]
            theta = [self.__dict__[f"b{k}_{name}"] for name in block.numbers()]
            blocks.append((block.with_fixed_values(given), theta))
        return blocks

    def convert_inputs(self, signals: Column) -> list[Scalar]:
        """Return inputs in SI in the units of the model."""
        kinds = [_find_conversion(self.model, name) for name in self.model.input_names]
        return [(u - offset) * (1.0 / factor) for u, (_, factor, offset) in zip(signals, kinds, strict=True)]

    def _outside(self, outputs: Sequence[Scalar]) -> list[Scalar]:
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
        for value in (*block.fixed_values(), *theta)
    ]


def _find_conversion(chain: Chain, name: str) -> tuple[str, float, float]:
    """Return the SI unit of a signal, with the factor and offset of its conversion."""
    spelling = chain.units.get(name, "1") or "1"
    for unit in SI:
        try:
            return unit, *units.find_conversion(spelling, unit)
        except UnitError:
            continue
    return spelling, 1.0, 0.0
