"""Bench: a plant in its loops, as one system in discrete time.

In every period, from t_k to t_k+1 = t_k + T:

    signals wanted at t_k → supervisor → plant advances to t_k+1 → sensors → observers → controllers

so that a row of a run at t_k is consistent: state, readings of that time, and the signals that they cause. Controllers
sample once per period; the plant advances in `substeps`. A bench is one kernel and a system, and runs on floats, in C,
in batches and with derivatives.

The drives of a bench are `reference` of its controller (`reference.DRIVE` for several), `manual` and `automatic` of a
manual mode, the drives of the plant without a controller, and for every sensor `noise.NAME` and `jitter.NAME`,
standard normal numbers; the default 0 is a run without noise.
"""

import math
from collections.abc import Mapping

from martensite.actuators.assembly import advance_steps
from martensite.actuators.assembly.base import AbstractSystemAround, DriveSignal
from martensite.actuators.mechanisms.base import Column, Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, option, param, part
from martensite.control.controllers.base import PLANNED, require_readings
from martensite.control.controllers.follower import Follower
from martensite.control.loop import names, period
from martensite.control.loop.parts import (
    SUPERVISORS,
    AbstractSupervisor,
    BenchState,
    Controllers,
    FaultTable,
    Observers,
    Sensors,
)
from martensite.control.observers.base import list_required
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import AbstractSwitch
from martensite.physics.laws.coupling import StepReport
from martensite.simulate.api import steps_in


class Bench(AbstractSystemAround, init=False):
    """A plant with its sensors, observers, controllers, supervisor and faults."""

    period: Number = param("s", "time from one sample to the next", above=0.0)
    sensors: Sensors = part("sensors by name; without sensors, the outputs of the plant are read", default=Sensors())
    observers: Observers = part("observers by name", default=Observers())
    controllers: Controllers = part("controllers by drive of the plant", default=Controllers())
    supervisor: AbstractSupervisor | None = part("supervisor of all signals", SUPERVISORS, default=None)
    faults: FaultTable = part("faults by name", default=FaultTable())
    substeps: int = part("steps of the plant in a period; 0: automatic", default=0)
    switching: str = option(
        "a switch (`pwm-voltage`): averaged over the period, or closed for its duty cycle from the start",
        "averaged",
        "pulses",
        default="averaged",
    )

    def check(self) -> None:
        check_bench(self)
        pieces = self.substeps or steps_in(self.plant, self.period)
        every = self.faults.members().values()
        counts = (
            mounted.count_delayed(self.period, sum(fault.latest(name) for fault in every))
            for name, mounted in self.sensors.members().items()
        )
        self.__dict__["_layout"] = (pieces, *counts)

    @property
    def turns(self) -> int:
        """Return the number of steps of the plant in a period."""
        return self.layout()[0]

    def sample_time(self) -> float:
        return self.period

    def description(self) -> str:
        kinds = [one.registered_name for one in self.controllers.members().values()]
        return f"{self.plant.description()}{', under ' if kinds else ''}{', '.join(kinds)}"

    def drives(self) -> list[DriveSignal]:
        return names.list_drives(self)

    def outputs(self) -> dict[str, Output]:
        return names.list_outputs(self)

    def profile(self, state: BenchState) -> list[Column]:
        return []

    def init(self, xp: Namespace, *drives: Scalar) -> BenchState:
        given = period.sorted_inputs(self, drives)
        idle = period.collect_idle(self, given)
        plant = period.apply_faults(self, xp, 0.0)
        state = plant.init(xp, *idle.values())
        readings = period.collect_truth(self, xp, plant, state, idle)
        rows = zip(self.sensors.members().values(), given.numbers, self.layout()[1:], strict=True)
        sensors = tuple(one.rest(xp, readings, noise, count) for one, (noise, _), count in rows)
        readings = period.collect_readings(self, sensors, readings)
        observers, controllers, supervisor, _ = period.begin_loop(self, xp, readings, given)
        return BenchState(0.0, state, sensors, observers, controllers, supervisor)

    # pyrefly: ignore[bad-override]  # signals are held over a step: it gets no moments
    def step(self, xp: Namespace, state: BenchState, *drives: Scalar, dt: Scalar) -> tuple[BenchState, StepReport]:
        given = period.sorted_inputs(self, drives)
        allowed = period.apply_supervisor(self, xp, state, given)
        signals = period.deliver_signals(self, xp, state.time, allowed.signals)
        plant = period.apply_faults(self, xp, state.time)
        after, report = advance_steps(xp, plant, state.plant, period.split_period(self, xp, signals), self.turns)
        time = state.time + self.period
        readings = period.collect_truth(self, xp, period.apply_faults(self, xp, time), after, signals)
        sensors = period.update_sensors(self, xp, state.sensors, readings, given, time)
        readings = period.collect_readings(self, sensors, readings)
        observers = period.update_observers(self, xp, state.observers, readings, allowed.signals)
        readings |= period.collect_estimates(self, observers)
        controllers = period.update_controllers(self, xp, state.controllers, readings, given)
        return BenchState(time, after, sensors, observers, controllers, tuple(allowed.memory)), report

    def observe(self, xp: Namespace, state: BenchState, *drives: Scalar) -> list[Scalar]:
        given = period.sorted_inputs(self, drives)
        allowed = period.apply_supervisor(self, xp, state, given)
        signals = period.deliver_signals(self, xp, state.time, allowed.signals)
        plant = period.apply_faults(self, xp, state.time)
        outputs = plant.observe(xp, state.plant, *signals.values())
        readings = [one.reading for one in state.sensors]
        estimates = [value for one in state.observers for value in one.estimates]
        controllers = [one.wanted for one in state.controllers]
        loops = [value for pair in zip(given.references, controllers, strict=True) for value in pair]
        own = period.collect_controller_outputs(self, xp, state.controllers).values()
        alarm = [] if self.supervisor is None else [allowed.alarm]
        shaped = period.collect_shaped(self, state.controllers)
        return [*outputs, *readings, *estimates, *loops, *shaped, *own, *alarm]


def check_bench(bench: Bench) -> None:
    """Raise `ParameterError` for a name that does not exist where it is used."""
    truths, drives = names.list_truths(bench), [drive.name for drive in bench.plant.drives()]
    for name, mounted in bench.sensors.members().items():
        for truth in mounted.sees():
            if truth not in truths:
                raise ParameterError(
                    f"Sensor `{name}` looks at `{truth}`, which the plant does not have. {suggest_name(truth, truths)}"
                )
    for name in bench.controllers.members():
        if name not in drives:
            raise ParameterError(f"There is no drive `{name}`. {suggest_name(name, drives)}")
    _check_readings(bench)
    _check_faults(bench, drives)
    _check_switching(bench)


def _check_readings(bench: Bench) -> None:
    readings = names.list_readings(bench)
    _check_estimates(bench)
    for name, observer in bench.observers.members().items():
        _require_names(f"Observer `{name}`", observer.reads(), readings)
        list_required(observer, {drive.name: 0.0 for drive in bench.plant.drives()})
    _check_leaders(bench)
    for controller in bench.controllers.members().values():
        require_readings(controller, [*readings, PLANNED])
        made_for = getattr(controller, "period", bench.period)
        if not math.isclose(made_for, bench.period):
            raise ParameterError(
                f"Controller `{controller.registered_name}` has a `period` of {made_for:g} s, but the bench one of "
                f"{bench.period:g} s; make them the same."
            )
    if bench.supervisor is not None:
        _require_names("The supervisor", bench.supervisor.reads(), readings)
        drives = [drive.name for drive in bench.plant.drives()]
        for name in bench.supervisor.drives():
            if name not in drives:
                raise ParameterError(
                    f"The supervisor names drive `{name}`, which the plant does not have. {suggest_name(name, drives)}"
                )


def _check_estimates(bench: Bench) -> None:
    """Raise `ParameterError` unless every estimate comes from one observer."""
    owners: dict[str, str] = {}
    for title, observer in bench.observers.members().items():
        for name in observer.estimates():
            if name in owners:
                raise ParameterError(
                    f"Observers `{owners[name]}` and `{title}` both estimate `{name}`; a bench has "
                    f"one estimate of a name."
                )
            owners[name] = title


def _check_leaders(bench: Bench) -> None:
    """Raise `ParameterError` unless every follower has one leader, and every named drive a controller."""
    members, led = bench.controllers.members(), list[str]()
    for drive, one in members.items():
        for name in (*one.led_drives(), *one.list_previews()):
            if name not in members:
                raise ParameterError(
                    f"The controller of `{drive}` names drive `{name}`, which has no controller. "
                    f"{suggest_name(name, members)}"
                )
        led += one.led_drives()
    for drive, one in members.items():
        follows, leaders = isinstance(one, Follower), led.count(drive)
        if follows != (leaders == 1) or leaders > 1:
            raise ParameterError(
                f"The controller of `{drive}` is {'a' if follows else 'no'} `follower`, and {leaders} others lead it: "
                "a follower has one leader, any other controller none."
            )


def _require_names(who: str, names: tuple[str, ...], readings: Mapping[str, object]) -> None:
    for name in names:
        if name not in readings:
            raise ParameterError(f"{who} reads `{name}`, which is not measured. {suggest_name(name, readings)}")


def _check_faults(bench: Bench, drives: list[str]) -> None:
    places = {"sensor": list(bench.sensors.members()), "drive": drives}
    for title, fault in bench.faults.members().items():
        for name, kind in fault.names().items():
            if name not in places[kind]:
                raise ParameterError(
                    f"Fault `{title}`: there is no {kind} `{name}`. {suggest_name(name, places[kind])}"
                )


def _check_switching(bench: Bench) -> None:
    sources = [one.source for one in bench.plant.actuators().values()]
    one = len(bench.plant.drives()) == 1 and len(sources) == 1
    duty = one and isinstance(sources[0], AbstractSwitch) and sources[0].unit == "1"
    if bench.switching == "pulses" and not duty:
        raise ParameterError(
            "Pulses are for a plant with one drive, a switch with a duty cycle, such as `pwm-voltage`."
        )
