"""Model predictive control: plans are compared on the model, and the best plan is started.

In every period:

    1. The model advances under the applied signals. A fraction of the difference between reading and model at the
       time of the reading becomes the offset d:

           d_k = d_k-1 + K (y_k - ŷ_k - d_k-1)

       With `tracking` the model gets u + v, where v is the answer of a PID law to y - ŷ, so that it follows the
       readings also if heating or cooling differ. An antagonistic drive that another one leads gets u - v.
    2. Plans start from the state of the model. Their cost compares them on the known reference ahead, less d
       (`martensite.control.controllers.planning`), with the integral of v added to all signals as an input disturbance
       (Pannocchia and Rawlings (2003)).
    3. The first signals of the best plan are applied for a period; the next search starts from this plan, shifted
       (receding horizon).

In the first sample the model is in the steady state without a plan. The horizon must be long enough: a cold wire must
be heated through its dead band, and cooled through the dead band of the return, before its stroke changes. With a
shorter horizon the best plan is not to move. `Mpc.for_system` measures on the model how long full and zero signal
need, and uses the sum; `cautions` reports a horizon that is too short.

One controller plans several drives: it has one drive itself, and each drive in `leads` has a `follower`. The
reference of the n-th follower is the set-point of the n-th reading in `also_measured`.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

from martensite.actuators.assembly import AbstractSystem, advance_steps
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, option, param, part, text
from martensite.control.controllers.base import (
    AHEAD,
    CONTROLLERS,
    AbstractController,
    Answer,
    Column,
    Readings,
    SignalLimits,
)
from martensite.control.controllers.pid import KEPT, Correction, PidMemory
from martensite.control.controllers.planning import Planner, PlanStart, Price, shift_plan
from martensite.control.controllers.time_scales import measure_reach
from martensite.control.observers.base import ESTIMATED, list_several
from martensite.control.observers.hidden_states import list_names, observe_model, place_hidden
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.signals.ahead import Ahead
from martensite.signals.base import AbstractWaveform
from martensite.simulate.api import steps_in


class PlanMemory(NamedTuple):
    """Memory of a predictive controller."""

    state: Any
    signals: tuple[Scalar, ...]
    """Signals of the drives in the next period."""
    planned: PlanStart
    offsets: tuple[Scalar, ...]
    """Offsets d of the readings from the model."""
    past: tuple[tuple[Scalar, ...], ...]
    """Outputs of the model in the last samples, newest first, by reading."""
    added: tuple[Scalar, ...] = ()
    """Signal that `tracking` adds in the model, then the memory of its law; empty without tracking."""


@CONTROLLERS.register("mpc")
class Mpc(AbstractController, SignalLimits):
    """A predictive controller that plans on a model."""

    cites = ("diehl2005",)

    model: AbstractSystem = part("model of the system")
    output: str = text("measured output of the model; default: named as the reading", default="")
    leads: tuple[str, ...] = text("other planned drives of the model, each with a `follower`", default=())
    also_measured: tuple[str, ...] = text(
        "readings that follow the references of the first of these drives", default=()
    )
    period: Number = param("s", "time from one sample to the next", above=0.0, typical="20 ms")
    horizon: Number = param("s", "horizon of the plans", above=0.0, typical="2 s")
    blocks: int = part("parts of the horizon with constant signals", default=20)
    rounds: int = part("rounds of the search in a period", default=1)
    price: Price = part("prices of a plan", default=Price())
    correction: Number = param(
        "1",
        "K, fraction of the difference of reading and model that is corrected in a sample",
        low=0.0,
        high=1.0,
        default=0.8,
    )
    tracking: Correction | None = part(
        "gains of a PID law on reading less model, whose signal is added in the model", default=None
    )
    state: str = option(
        "source of temperature and fraction of the model: the model itself, or "
        "the observer of a bench, as `estimated.temperature` and `estimated.martensite_fraction`",
        "model",
        "observer",
        default="model",
    )
    kept: int = part("largest age of a reading that is compared, in samples", default=8)

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
    ) -> Self:
        """Return a controller whose horizon is the time in which the model warms up and cools down.

        Args:
            model: model of the system with one drive.
            measured: reading that follows the reference.
            reference: waveform of the reference, in SI.
            period: sample period [s].
            price: prices of a plan.
            high: largest signal; the least is 0.
            output: measured output of the model; default: named as the reading.

        Raises:
            ParameterError: the output does not exist, or full signal does not move it.
        """
        reach = measure_reach(model, _find_output(model, output or measured.removeprefix(ESTIMATED)), 0.0, high)
        return cls(
            model=model,
            measured=measured,
            output=output,
            reference=reference,
            period=period,
            horizon=max(reach.up + reach.down, period),
            high=high,
            price=price,
        )

    def check(self) -> None:
        super().check()
        self._check_drives()
        for output in self.followed_outputs:
            _find_output(self.model, output)
        for name in ("blocks", "rounds", "kept"):
            value = self.__dict__[name]
            if not isinstance(value, int) or value < 1:
                raise ParameterError(f"`{name}` must be a whole number above 0, but is {value!r}.")
        if self.horizon < self.period:
            raise ParameterError(f"The horizon of {self.horizon:g} s is shorter than the period of {self.period:g} s.")
        turns = [steps_in(self.model, time) for time in (self.period, self.horizon / self.blocks)]
        self.__dict__["_layout"] = (self.blocks, self.rounds, self.kept, *turns)
        self.__dict__["_example"] = self.model.init(floats, *[self.idle] * len(self.model.drives()))

    def _check_drives(self) -> None:
        if self.tracking is not None and (len(self._leads) > 1 or self._also):
            raise ParameterError("`tracking` is for one reading, and one drive or two that pull against each other.")
        drives = [drive.name for drive in self.model.drives()]
        for name in self._leads:
            if name not in drives:
                raise ParameterError(f"The model of `mpc` has no drive `{name}`. {suggest_name(name, drives)}")
        left = [name for name in drives if name not in self._leads]
        if len(left) != 1:
            raise ParameterError(
                f"The model of `mpc` must have one drive that it does not lead, but has {', '.join(left) or 'none'}; "
                f'write such as `leads = ["{drives[-1]}"]`, and give what is led a controller of kind `follower`.'
            )
        if len(self._also) > len(self._leads):
            raise ParameterError(
                f"`also_measured` names {len(self._also)} readings, but `mpc` leads {len(self._leads)} drives; each "
                "reading follows the reference of one of them."
            )

    def cautions(self) -> list[str]:
        if self._leads:
            return []
        start = measure_reach(self.model, self.followed_outputs[0], self.low, self.high).start
        if self.horizon >= start:
            return []
        return [
            f"The horizon of {self.horizon:.3g} s ends before full signal moves `{self.followed_outputs[0]}`, after "
            f"{start:.3g} s: plans see what heating costs and hardly what it gains."
        ]

    @property
    def _leads(self) -> tuple[str, ...]:
        return list_several(self.leads)

    @property
    def _also(self) -> tuple[str, ...]:
        return list_several(self.also_measured)

    @property
    def _own(self) -> str:
        return next(drive.name for drive in self.model.drives() if drive.name not in self._leads)

    @property
    def _readings(self) -> tuple[str, ...]:
        return (self.measured, *self._also)

    @property
    def followed_outputs(self) -> tuple[str, ...]:
        """Return the measured outputs of the model."""
        own = self.output or self.measured
        return tuple(name.removeprefix(ESTIMATED) for name in (own, *self._also))

    def reads(self) -> tuple[str, ...]:
        hidden = [ESTIMATED + name for name in list_names(self.model)]
        return (*self._readings, *hidden) if self.state == "observer" else self._readings

    def led_drives(self) -> tuple[str, ...]:
        return self._leads

    def list_previews(self) -> dict[str, tuple[float, ...]]:
        length = self.horizon / self.blocks
        times = tuple(length * k for k in range(1, self.blocks + 1))
        return dict.fromkeys((self._own, *self._leads[: len(self._also)]), times)

    def share_signals(self, memory: Column) -> dict[str, Scalar]:
        signals = self._name_signals(self.unflatten(memory))
        return {name: signals[name] for name in self._leads}

    # ------------------------------------------------------------ the kernel

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        idle = (xp.clip(0.0, self.low, self.high),) * len(self.model.drives())
        state = self.model.init(xp, *idle)
        outputs = self._observe(xp, state, idle)
        plan, zeros = idle * self.blocks, (0.0,) * (len(idle) * self.blocks)
        offsets = tuple(readings[name] - y for name, y in zip(self._readings, outputs, strict=True))
        past = tuple((y,) * self.kept for y in outputs)
        added = () if self.tracking is None else (0.0, *self.tracking.rest(xp, readings[self.measured], outputs[0]))
        return flatten_numbers(PlanMemory(state, idle, PlanStart(plan, plan, zeros), offsets, past, added))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before = self.unflatten(memory)
        if isinstance(dt, float | int) and dt == 0.0:
            return self._name_signals(before)[self._own], memory
        corrected = self._correct_offsets(xp, self._go_on(xp, before, readings), readings)
        planned = self._plan(xp, corrected, self._list_wanted(corrected, reference, readings))
        signals = planned.plan[: len(corrected.signals)]
        after = self._track_reading(xp, corrected._replace(signals=signals, planned=planned), readings, dt)
        return self._name_signals(after)[self._own], flatten_numbers(after)

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        if self._leads:
            raise ParameterError("A controller that leads others runs on a bench, not as a separate drive.")
        (times,) = self.list_previews().values()
        waves = (Ahead(waveform=self.reference, lead=lead) for lead in times)
        ahead = {f"{AHEAD}{self._own}.{k}": wave.value(time) for k, wave in enumerate(waves, 1)}
        return super().__call__(time, {**measurement, **ahead}, memory)

    def _name_signals(self, memory: PlanMemory) -> dict[str, Scalar]:
        return {drive.name: u for drive, u in zip(self.model.drives(), memory.signals, strict=True)}

    def _go_on(self, xp: Namespace, memory: PlanMemory, readings: Readings) -> PlanMemory:
        turns = self.layout()[3]
        signals: Column = memory.signals
        if memory.added:
            signals = [xp.clip(u, self.low, self.high) for u in self._add_opposed(signals, memory.added[0])]
        state, _ = advance_steps(xp, self.model, memory.state, [(signals, self.period / turns)], turns)
        if self.state == "observer":
            hidden = [readings[ESTIMATED + name] for name in list_names(self.model)]
            state = place_hidden(xp, self.model, state, hidden, memory.signals)
        outputs = self._observe(xp, state, memory.signals)
        past = tuple((y, *old[:-1]) for y, old in zip(outputs, memory.past, strict=True))
        return memory._replace(state=state, past=past)

    def _observe(self, xp: Namespace, state: Any, signals: Column) -> list[Scalar]:
        outputs = observe_model(xp, self.model, state, signals)
        return [outputs[name] for name in self.followed_outputs]

    def _correct_offsets(self, xp: Namespace, memory: PlanMemory, readings: Readings) -> PlanMemory:
        rows = zip(self._readings, memory.past, memory.offsets, strict=True)
        errors = ((d, readings[name] - self._recall_model(xp, name, past, readings)) for name, past, d in rows)
        return memory._replace(offsets=tuple(d + self.correction * (error - d) for d, error in errors))

    def _recall_model(self, xp: Namespace, name: str, past: Column, readings: Readings) -> Scalar:
        late = readings.get(f"{name}.age", 0.0) / self.period
        model = past[0]
        for k, output in enumerate(past[1:], 1):
            model = xp.where(late > k - 0.5, output, model)
        return model

    def _track_reading(self, xp: Namespace, memory: PlanMemory, readings: Readings, dt: Scalar) -> PlanMemory:
        """Return the memory with the signal that tracking adds, within the limits of all signals."""
        if self.tracking is None:
            return memory
        before = PidMemory(*memory.added[1:])
        model = self._recall_model(xp, self.measured, memory.past[0], readings)
        signals = self._name_signals(memory)
        low, high = self.low - signals[self._own], self.high - signals[self._own]
        for name in self._leads:
            low, high = xp.minimum(low, signals[name] - self.high), xp.maximum(high, signals[name] - self.low)
        law = self.tracking.law.rebuilt({"low": low, "high": high})
        added, after = law.answer(xp, self.tracking.gains, before, readings[self.measured], model, dt)
        return memory._replace(added=(added, *after))

    def _add_opposed(self, signals: Column, added: Scalar) -> list[Scalar]:
        """Return the signals with an addition to the own drive, and its opposite to the led drives."""
        rows = zip(self.model.drives(), signals, strict=True)
        return [u - added if drive.name in self._leads else u + added for drive, u in rows]

    def _list_wanted(self, memory: PlanMemory, reference: Scalar, readings: Readings) -> list[Scalar]:
        rows: list[list[Scalar]] = []
        for (drive, times), offset in zip(self.list_previews().items(), memory.offsets, strict=True):
            now = reference if drive == self._own else readings[f"{AHEAD}{drive}.0"]
            ahead = (readings[f"{AHEAD}{drive}.{k}"] for k in range(1, len(times) + 1))
            rows.append([r - offset for r in (now, *ahead)])
        return [r for column in zip(*rows, strict=True) for r in column]

    def _plan(self, xp: Namespace, memory: PlanMemory, wanted: list[Scalar]) -> PlanStart:
        blocks, rounds, _, _, turns = self.layout()
        length = self.horizon / blocks
        limits, count = (self.low, self.high), len(memory.signals)
        start = (memory.state, memory.signals, wanted)
        shifts = self._add_opposed((0.0,) * count, memory.added[1]) if memory.added else ()
        planner = Planner(self.model, self.followed_outputs, self.price, limits, blocks, turns, length, *start, shifts)
        moved = (tuple(shift_plan(one, count, self.period / length)) for one in memory.planned)
        return planner.search(xp, rounds, PlanStart(*moved))

    def unflatten(self, memory: Column) -> PlanMemory:
        """Return the named memory from a flat column."""
        drives, readings = len(self.model.drives()), len(self._readings)
        plan = (0.0,) * (drives * self.blocks)
        past = ((0.0,) * self.kept,) * readings
        example = self.__dict__["_example"]
        added = () if self.tracking is None else (0.0,) * (1 + KEPT)
        shape = PlanMemory(example, (0.0,) * drives, PlanStart(plan, plan, plan), (0.0,) * readings, past, added)
        return NestedShape(shape).rebuild(memory)


def _find_output(model: AbstractSystem, output: str) -> str:
    if output not in model.outputs():
        raise ParameterError(f"The model has no output `{output}`. {suggest_name(output, model.outputs())}")
    return output
