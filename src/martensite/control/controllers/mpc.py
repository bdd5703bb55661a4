"""Model predictive control: many plans are tried on the model, and the best one is begun.

In every period:

    1. the model goes on under the signal that was applied; what it says then is compared with
       the reading of the same time, and a part of the difference becomes its offset d:
           d_k = d_k-1 + K (y_k - ŷ_k - d_k-1)
    2. plans are simulated from the state of the model, in C, all side by side, and compared on
       the reference ahead, which is known, less d (`martensite.control.controllers.planning`)
    3. the first signal of the best plan is applied until the next period, when all starts again
       from this plan, moved on (receding horizon).

The horizon decides whether anything moves: a cold wire must be heated through its dead band, and cooled through that of
the way back, before its stroke changes. A horizon that ends before sees that heating costs and gains nothing, and the
best plan is none. `Mpc.for_system` measures on the model how long full signal and none need, and takes the sum;
`cautions` says when a given horizon is too short.

It is no kernel: it runs outside of a bench (`simulate_bench(bench, T, outside=...)`), in
`simulate_controlled`, or in a loop of one's own. All that it remembers is passed in and out.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import option, param, part, text
from martensite.control.controllers.base import CONTROLLERS, AbstractController, SignalLimits, require_readings
from martensite.control.controllers.planning import Moment, Planner, PlanSearch, Price, measure_reach, shift_plan
from martensite.control.observers.base import ESTIMATED
from martensite.control.observers.hidden_states import list_names, place_hidden
from martensite.kernels import floats
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.signals.base import AbstractWaveform
from martensite.simulate.api import steps_in
from martensite.simulate.lanes import Lanes, Numbers


class Planned(NamedTuple):
    """What a predictive controller remembers; its engines are tools without a past."""

    count: int
    """Samples so far."""
    state: Numbers
    """Of the model, now."""
    signal: float
    """That of the period that begins."""
    plan: Numbers
    """All signals of it, shape (blocks,)."""
    offset: float
    """What readings have more than the model, d."""
    past: tuple[float, ...]
    """What the model said in the last samples, latest first."""
    cost: float
    """Of the plan."""
    shape: NestedShape
    """Of the state."""
    model: Lanes
    planner: Planner


@CONTROLLERS.register("mpc")
class Mpc(AbstractController, SignalLimits):
    """A predictive controller over the compiled march of a model."""

    cites = ("deboer2005",)
    kernel = False

    model: AbstractSystem = part("the system as it is believed to be, with one drive")
    output: str = text("output of the model that is measured; none: called as the reading", default="")
    period: float = param("s", "time from one sample to the next", above=0.0, typical="20 ms")
    horizon: float = param("s", "how far plans reach", above=0.0, typical="2 s")
    blocks: int = part("parts of the horizon, each with a signal of its own", default=20)
    price: Price = part("what a plan is charged for", default=Price())
    search: PlanSearch = part("how plans are searched", default=PlanSearch())
    correction: float = param(
        "1",
        "K: part of a difference between reading and model that is believed in a sample",
        low=0.0,
        high=1.0,
        default=0.8,
    )
    state: str = option(
        "where temperature and fraction of the model come from: from its own course, or from "
        "the observer of a bench, as `estimated.temperature` and `estimated.martensite_fraction`",
        "model",
        "observer",
        default="model",
    )
    kept: int = part("samples after which a late reading is compared no more", default=50)

    @classmethod
    def for_system(
        cls,
        model: AbstractSystem,
        *,
        measured: str,
        reference: AbstractWaveform,
        period: float,
        price: Price,
        high: float = 1.0,
        output: str = "",
        search: PlanSearch | None = None,
    ) -> Self:
        """A controller whose horizon is what the model needs to warm up and to cool down.

        Args:
            model: the system as it is believed to be, with one drive.
            measured: reading that shall follow the reference.
            reference: what it shall follow, in its SI unit.
            period: time from one sample to the next [s].
            price: what a plan is charged for.
            high: largest signal; the least one is 0.
            output: output of the model that is measured, if it is called otherwise.
            search: how plans are searched.

        Raises:
            ParameterError: the output does not exist, or full signal does not move it.
        """
        found = measure_reach(model, _find_output(model, output or measured), 0.0, high)
        return cls(
            model=model,
            measured=measured,
            output=output,
            reference=reference,
            period=period,
            horizon=max(found.up + found.down, period),
            high=high,
            price=price,
            search=search or PlanSearch(),
        )

    def check(self) -> None:
        """Raise `ParameterError` where nothing could be planned."""
        if len(self.model.drives()) != 1:
            raise ParameterError(
                f"The model of a predictive controller must have one drive, but has {len(self.model.drives())}."
            )
        _find_output(self.model, self.followed_output)
        super().check()
        for name in ("blocks", "kept"):
            value = self.__dict__[name]
            if not isinstance(value, int) or value < 1:
                raise ParameterError(f"`{name}` must be a whole number above 0, but is {value!r}.")
        if self.horizon < self.period:
            raise ParameterError(f"The horizon of {self.horizon:g} s is shorter than the period of {self.period:g} s.")

    def cautions(self) -> list[str]:
        """Whether the horizon ends before full signal moves anything."""
        start = measure_reach(self.model, self.followed_output, self.low, self.high).start
        if self.horizon >= start:
            return []
        return [
            f"The horizon of {self.horizon:.3g} s ends before full signal moves `{self.followed_output}`, after "
            f"{start:.3g} s: plans see what heating costs and hardly what it gains."
        ]

    @property
    def followed_output(self) -> str:
        """Output of the model that is measured."""
        return self.output or self.measured.removeprefix(ESTIMATED)

    def reads(self) -> tuple[str, ...]:
        """Names of all readings it needs."""
        hidden = [ESTIMATED + name for name in list_names(self.model)]
        return (self.measured, *hidden) if self.state == "observer" else (self.measured,)

    def init(self) -> Planned:
        """The model at rest, nothing planned; compiles the model."""
        lanes = Lanes(self.model, self.search.plans)
        planner = Planner(lanes, self.followed_output, self.price, self.search, (self.low, self.high))
        model, idle = Lanes(self.model, 1), self.idle
        model.reset(idle)
        shape = NestedShape(self.model.init(floats, idle))
        plan = np.full(self.blocks, idle)
        return Planned(0, model.state, idle, plan, 0.0, (), 0.0, shape, model, planner)

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Planned]:
        """Signal at `time` [s] and the new memory; called once in every period.

        Raises:
            ParameterError: something that it reads is not measured.
        """
        require_readings(self, measurement)
        known = self._gone_on(memory, measurement)
        known = self._correct_offset(known, measurement)
        turns, dt = self._steps(self.horizon / self.blocks)
        ahead = time + dt * np.arange(1, self.blocks * turns + 1)
        wanted = np.array([self.reference.value(t) for t in ahead.tolist()]) - known.offset
        guess = shift_plan(known.plan, self.period * self.blocks / self.horizon)
        rng = np.random.default_rng((self.search.seed, known.count))
        moment = Moment(known.state, known.signal, wanted)
        plan, cost = known.planner.best(moment, guess, dt, rng)
        signal = float(plan[0])
        return signal, known._replace(count=known.count + 1, signal=signal, plan=plan, cost=cost)

    def _gone_on(self, memory: Planned, measurement: Mapping[str, float]) -> Planned:
        """The model at this sample, under the signal since the last one."""
        model = memory.model
        model.state = memory.state
        if memory.count:
            turns, dt = self._steps(self.period)
            model.advance(np.full((turns, 1, 1), memory.signal), dt, shown=False)
        if self.state == "observer":
            model.state = self._place_state(memory, model.state, measurement)
        value = model.observe(memory.signal)[model.names.index(self.followed_output), 0]
        past = (float(value), *memory.past)[: self.kept]
        return memory._replace(state=model.state, past=past)

    def _place_state(self, memory: Planned, state: Numbers, measurement: Mapping[str, float]) -> Numbers:
        at = [measurement[name] for name in self.reads()[1:]]
        nested = memory.shape.rebuild(state[:, 0].tolist())
        found = place_hidden(floats, self.model, nested, at, [memory.signal])
        return np.array(flatten_numbers(found))[:, None]

    def _correct_offset(self, memory: Planned, measurement: Mapping[str, float]) -> Planned:
        """With the offset that the reading of this sample gives."""
        late = round(measurement.get(f"{self.measured}.age", 0.0) / self.period)
        model = memory.past[min(late, len(memory.past) - 1)]
        missing = measurement[self.measured] - model - memory.offset
        gain = self.correction if memory.count else 1.0
        return memory._replace(offset=memory.offset + gain * missing)

    def _steps(self, length: float) -> tuple[int, float]:
        """Steps of the model in a length of time [s], and how long each is [s]."""
        turns = steps_in(self.model, length)
        return turns, length / turns


def _find_output(model: AbstractSystem, output: str) -> str:
    if output not in model.outputs():
        raise ParameterError(f"The model has no output `{output}`. {suggest_name(output, model.outputs())}")
    return output
