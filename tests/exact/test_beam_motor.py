"""The motor on the beam: against the explicit equations, facts of energy, and other solvers.

Sources of truth: the equations of motion solved by hand for their second derivatives (2 × 2, or
by numpy for several modes), conservation of energy, balances of power in steady states, scipy's
DOP853 over the same accelerations, roots of the characteristic equation of the beam, and a path
of the bare law for the work of the wire.
"""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy import integrate

from martensite.actuators.assembly import Machine, System
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanics.beam_modes import CantileverBeam, beam_modes, solve_angular_frequencies
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.beam_motor import BeamMotor, modal_numbers
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.kernels.program import Program
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import CurrentSource, PrescribedTemperature
from martensite.physics.laws.strip_laws import Elahinia
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.constant import Constant
from martensite.signals.ramp import Ramp
from martensite.signals.step import Step
from martensite.simulate.api import simulate
from martensite.simulate.point import PathLeg, material_point
from martensite.simulate.result import Result

PRINTED: dict[str, Any] = {
    "mass": 0.25,
    "stiffness": 541.0,
    "damping": 0.07,
    "unbalance": 0.012,
    "eccentricity": 0.02,
    "rotor_inertia": 0.82e-4,
    "rotor_friction": 8.17e-7,
    "torque_constant": 0.0211,
    "back_emf": 0.0211,
    "resistance": 41.0,
    "inductance": 3.1e-3,
}
"""Table 3 of the thesis."""
SLOW: dict[str, Any] = PRINTED | {"mass": 0.1961, "damping": 0.2335, "resistance": 6.22}
"""The set calibrated to the measured ramp: steady within a few seconds."""
HEAVY: dict[str, Any] = PRINTED | {"damping": 0.1, "unbalance": 0.05}
"""An unbalance that brings the tip to large amplitudes within a second."""
ISOLATED: dict[str, Any] = PRINTED | {"damping": 0.0, "rotor_friction": 0.0, "torque_constant": 0.0, "back_emf": 0.0}
BEAM = CantileverBeam(E=69e9, density=2700.0, width=0.038, height=0.003, length=0.32, tip_mass=0.17)
LENGTH = 0.331
LAW = Elahinia(
    E_A=75e9,
    E_M=28e9,
    eps_L=0.04,
    Theta=0.0,
    T_ref=295.15,
    M_f=315.15,
    M_s=325.15,
    A_s=341.15,
    A_f=351.15,
    C_M=10.3e6,
    C_A=10.3e6,
)
HOT = 361.15


MOTOR = {name: value for name, value in PRINTED.items() if name not in ("damping",)}


def modal(count: int) -> dict[str, Any]:
    """How the beam bends, in so many modes."""
    return modal_numbers(beam_modes(BEAM, count))


def dampings(motor: BeamMotor) -> np.ndarray:
    """c_k of every mode: all with the damping ratio of the first."""
    rows = [(motor.mass, motor.stiffness)]
    for k in range(2, motor.count + 1):
        rows.append((getattr(motor, f"mass_{k}"), getattr(motor, f"stiffness_{k}")))
    ratio = motor.damping / (2.0 * math.sqrt(motor.stiffness * motor.mass))
    return np.array([2.0 * ratio * math.sqrt(k * m) for m, k in rows])


def wire(**changes: Any) -> Wire:
    numbers: dict[str, Any] = {
        "diameter": 0.375e-3,
        "length": LENGTH,
        "density": 6450.0,
        "heat_capacity": 837.0,
        "latent_heat": 24.2e3,
    }
    ohms = PerLengthResistance(r_A=8.3, r_M=8.3)
    return Wire(law=LAW, resistance=ohms, **(numbers | changes))


def coupled(slack: float, hot: bool = False, numbers: dict[str, Any] = SLOW) -> System:
    """The beam with a wire; hot: austenite from the start, at a prescribed temperature."""
    motor = BeamMotor(**numbers, wire="inclined", wire_length=LENGTH, slack=slack)
    return System(
        element=wire(initial_fraction=0.0) if hot else wire(),
        mechanism=motor,
        source=PrescribedTemperature() if hot else CurrentSource(),
        environment=Environment(temperature=295.15, cooling=ConstantCooling(h=128.0)),
    )


def traced(motor: BeamMotor) -> Any:
    """x', x'', φ', φ'', i' of [x, x', φ, φ', i] under a voltage, from the kernel."""
    program = Program()
    twin = motor.rebuilt({leaf.path: program.parameter(leaf.path) for leaf in motor.leaves()})

    def rates(xp: Any, x: Any, v: Any, a: Any, w: Any, i: Any, volts: Any) -> list[Any]:
        motion = Motion((x, a, 0.0), (v, w, i), (0.0, 0.0, 0.0))
        found = twin.release(xp, motion, [0.0, 0.0, 0.0], [volts])
        return [v, found[0], w, found[1], found[2]]

    program.add("rates", ["x", "v", "a", "w", "i", "volts"], rates)
    return program.bind_floats(*(leaf.value for leaf in motor.leaves()))["rates"]


def by_hand(p: dict[str, Any], state: Any, volts: float) -> list[float]:
    """The same, from the equations solved for x'' and φ''."""
    x, v, a, w, i = state
    q = p["unbalance"] * p["eccentricity"] * math.cos(a)
    inertia = p["rotor_inertia"] + p["unbalance"] * p["eccentricity"] ** 2
    d = p["mass"] * inertia - q * q
    thrown = p["unbalance"] * p["eccentricity"] * w * w * math.sin(a)
    f1 = thrown - p["damping"] * v - p["stiffness"] * x
    f2 = p["torque_constant"] * i - p["rotor_friction"] * w
    change = (volts - p["back_emf"] * w - p["resistance"] * i) / p["inductance"]
    return [v, (inertia * f1 - q * f2) / d, w, (p["mass"] * f2 - q * f1) / d, change]


def states(count: int) -> np.ndarray:
    draw = np.random.default_rng(3)
    size = np.array([0.05, 2.0, 4.0, 60.0, 0.4])
    return draw.uniform(-1.0, 1.0, (count, 5)) * size


# ---------------------------------------------------------------- equations of motion


def test_accelerations_are_those_of_the_equations_solved_by_hand() -> None:
    rates = traced(BeamMotor(**PRINTED))
    for state in states(50):
        assert rates(*state, 5.0) == pytest.approx(by_hand(PRINTED, state, 5.0), rel=1e-11)


def test_dry_friction_opposes_the_rotor() -> None:
    rubbed = PRINTED | {"dry_friction": 1e-3, "friction_rate": 0.1}
    for speed in (-5.0, 5.0):
        state = [0.0, 0.0, math.pi / 2, speed, 0.0]  # cos φ = 0: rotor and tip uncoupled
        change = traced(BeamMotor(**rubbed))(*state, 0.0)[3] - by_hand(PRINTED, state, 0.0)[3]
        inertia = PRINTED["rotor_inertia"] + PRINTED["unbalance"] * PRINTED["eccentricity"] ** 2
        assert change == pytest.approx(-math.copysign(1e-3, speed) / inertia, rel=1e-9)


@pytest.mark.parametrize("count", [1, 3])
def test_power_of_the_demand_is_change_of_energy_and_losses(count: int) -> None:
    """With V = 0 and K_T = K_B, along any motion."""
    motor = BeamMotor(**(MOTOR | modal(count)), damping=0.07)
    q, v, a = np.random.default_rng(5).uniform(-1.0, 1.0, (3, count + 2))

    def energy(t: float) -> float:
        place, rate = q + t * v + 0.5 * t * t * a, v + t * a
        return math.fsum(motor.energy(floats, Motion(tuple(place), tuple(rate), ())))

    needs = motor.demand(floats, Motion(tuple(q), tuple(v), tuple(a)), [0.0])
    lost = motor.rotor_friction * v[-2] ** 2 + motor.resistance * v[-1] ** 2
    lost += sum(c * rate * rate for c, rate in zip(dampings(motor), v, strict=False))
    change = (energy(1e-4) - energy(-1e-4)) / 2e-4
    assert np.dot(needs, v) == pytest.approx(change + lost, rel=1e-6)


# ---------------------------------------------------------------- energy


def drift(coupling: str, solver: str = "DOP853") -> float:
    """Largest relative change of the energy of the isolated system in 5 s."""
    motor = BeamMotor(**ISOLATED, coupling=coupling)
    rates = traced(motor)
    start = [0.02, 0.3, 0.2, 40.0, 0.0]
    found = integrate.solve_ivp(lambda t, y: rates(*y, 0.0), (0.0, 5.0), start, method=solver, rtol=1e-12, atol=1e-13)
    energies = [math.fsum(motor.energy(floats, Motion((x, a, 0.0), (v, w, i), ()))) for x, v, a, w, i in found.y.T]
    return float(np.ptp(energies) / energies[0])


def test_isolated_energy_is_constant() -> None:
    assert drift("lagrange") < 1e-9


# ---------------------------------------------------------------- steady states


@cache
def captured() -> Result:
    """Near resonance at 4 V, long after a slow start."""
    return slowly(4.0)


def slowly(volts: float) -> Result:
    """Up to a voltage in 12 s, and some time there."""
    wave = Ramp(high=volts, end=12.0)
    machine = Machine(mechanism=BeamMotor(**SLOW))
    return simulate(machine, {"motor": wave}, 24.0, step=5e-4, samples=24001)


def last(result: Result, name: str, share: float = 0.1) -> np.ndarray:
    """The end of a column: whole turns of the rotor."""
    angle = np.array(result["rotor_angle"])
    turns = math.floor((angle[-1] - angle[int((1.0 - share) * angle.size)]) / (2.0 * math.pi))
    first = int(np.searchsorted(angle, angle[-1] - 2.0 * math.pi * turns))
    return np.array(result[name])[first:]


def test_captured_steady_state_balances_power_and_torque() -> None:
    p = SLOW
    speed, current, velocity = (last(captured(), name) for name in ("rotor_speed", "motor_current", "velocity"))
    natural = math.sqrt(p["stiffness"] / p["mass"])
    assert 0.9 * natural < speed.mean() < natural
    given = p["torque_constant"] * np.mean(current * speed)
    taken = p["rotor_friction"] * np.mean(speed**2) + p["damping"] * np.mean(velocity**2)
    assert given == pytest.approx(taken, rel=1e-3)
    amplitude = 0.5 * np.ptp(last(captured(), "displacement"))
    omega = speed.mean()
    torque = p["rotor_friction"] * omega + 0.5 * p["damping"] * omega * amplitude**2
    assert p["torque_constant"] * current.mean() == pytest.approx(torque, rel=0.01)


# ---------------------------------------------------------------- the march


def test_the_end_of_a_fast_run_is_right_too() -> None:
    """An overload from rest, past the resonance: every signal to the tolerance asked for."""
    machine = Machine(mechanism=BeamMotor(**SLOW))
    run = simulate(machine, {"motor": Constant(level=10.0)}, 2.0, tolerance=1e-3, samples=201)
    rates = traced(BeamMotor(**SLOW))
    found = integrate.solve_ivp(
        lambda t, y: rates(*y, 10.0), (0.0, 2.0), np.zeros(5), method="DOP853", rtol=1e-10, atol=1e-12
    )
    assert run.accuracy is not None and run.accuracy < 1e-3
    assert run["rotor_speed"][-1] == pytest.approx(found.y[3, -1], rel=2e-3)


# ---------------------------------------------------------------- modes


def test_modes_of_the_motor_at_rest_are_those_of_the_beam() -> None:
    """Frequencies from the accelerations of the mechanism against the characteristic equation."""
    numbers: dict[str, Any] = MOTOR | modal(4) | {"damping": 0.0, "unbalance": 0.0}
    motor = BeamMotor(**numbers)
    rest = (0.0,) * 6
    for k, omega in enumerate(solve_angular_frequencies(BEAM, 4)):
        place = tuple(1e-3 if j == k else 0.0 for j in range(6))
        found = motor.release(floats, Motion(place, rest, rest), [0.0] * 6, [0.0])
        assert found[k] == pytest.approx(-omega * omega * 1e-3, rel=2e-6)
        assert [found[j] for j in range(4) if j != k] == [0.0] * 3


def test_the_unbalance_couples_the_modes_as_one_force_at_the_tip() -> None:
    motor = BeamMotor(**(MOTOR | modal(3)), damping=0.07)
    q, v = np.random.default_rng(7).uniform(-1.0, 1.0, (2, 5)) * [0.02, 0.02, 0.02, 3.0, 1.0]
    found = motor.release(floats, Motion(tuple(q), tuple(50 * v), (0.0,) * 5), [0.0] * 5, [3.0])
    masses = np.array([motor.mass, motor.mass_2, motor.mass_3])
    springs = np.array([motor.stiffness, motor.stiffness_2, motor.stiffness_3])
    moment, angle, speed = motor.unbalance * motor.eccentricity, q[3], 50 * v[3]
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = np.diag(masses)
    matrix[3, :3] = matrix[:3, 3] = moment * math.cos(angle)
    matrix[3, 3] = motor.rotor_inertia + motor.unbalance * motor.eccentricity**2
    side = np.empty(4)
    side[:3] = moment * speed**2 * math.sin(angle) - springs * q[:3] - dampings(motor) * 50 * v[:3]
    side[3] = motor.torque_constant * 50 * v[4] - motor.rotor_friction * speed
    assert found[:4] == pytest.approx(np.linalg.solve(matrix, side), rel=1e-9)


def test_one_mode_of_a_beam_is_the_mass_on_a_spring() -> None:
    """With higher modes of next to no mass and much stiffness nothing changes but the names."""
    stiff: dict[str, Any] = {"modes": "2", "mass_2": 1e-4, "stiffness_2": 1e7}
    one, two = (
        simulate(
            Machine(mechanism=BeamMotor(**(SLOW | more))), {"motor": Constant(level=3.0)}, 1.0, step=2e-4, samples=101
        )
        for more in ({}, stiff)
    )
    assert two["displacement"] == pytest.approx(one["displacement"], abs=2e-5)
    assert two["mode_1"] == pytest.approx(one["displacement"], abs=2e-5)


def test_what_is_missing_or_absurd_is_refused() -> None:
    with pytest.raises(ParameterError, match="needs `mass_2`"):
        BeamMotor(**PRINTED, modes="2")
    with pytest.raises(ParameterError, match="wire_length"):
        BeamMotor(**PRINTED, wire="inclined")
    with pytest.raises(ParameterError, match="holds the unbalance"):
        BeamMotor(**PRINTED).with_values({"mass": 0.01})
    with pytest.raises(ParameterError, match="at most 4"):
        modal_numbers(beam_modes(BEAM, 5))


# ---------------------------------------------------------------- the wire


@pytest.mark.parametrize("slack", [-0.02, 0.0, 0.015])
def test_path_and_lever_of_the_wire(slack: float) -> None:
    """F_w from the geometry of the thesis, l(x) from the positions of both ends."""
    motor = coupled(slack).mechanism
    assert isinstance(motor, BeamMotor)
    theta = math.pi / 12
    for x in (-0.05, 0.0, 0.03, 0.06):
        ends = np.array([LENGTH * math.cos(theta), LENGTH * math.sin(theta) + x])
        length = float(np.hypot(*ends))
        assert LENGTH - motor.contraction(floats, [x, 1.0, 0.0])[0] == pytest.approx(length)
        force, torque, volts = motor.supply(floats, [x, 1.0, 0.0], [7.0], [0.0] * 3)
        assert force == pytest.approx(-7.0 * ends[1] / length, rel=1e-12)
        assert torque == volts == 0.0
    (home,) = motor.assembled_elongations(floats, [0.04 * LENGTH])  # as long as the cold wire is
    assert home == pytest.approx(-slack * LENGTH)
    (home,) = motor.assembled_elongations(floats, [-0.05])
    assert home == -0.05  # never stretched


@cache
def driven() -> Result:
    """Hot wire, oscillation into and out of slack, every step a sample."""
    waves = {"motor": Constant(level=14.0), "drive": Constant(level=HOT)}
    return simulate(coupled(0.015, True, HEAVY), waves, 2.5, step=2.5e-4, samples=10001)


def test_slack_wire_never_pushes() -> None:
    run = driven()
    force, strain = np.array(run["force"]), np.array(run["strain"])
    x, fraction = np.array(run["displacement"]), np.array(run["martensite_fraction"])
    motor = coupled(0.015).mechanism
    assert isinstance(motor, BeamMotor)
    path = np.array([motor.path(floats, value) for value in x.tolist()])
    asked = -0.015 + path / LENGTH - 1.0
    taut = force > 0.0
    assert 0.02 < taut.mean() < 0.5
    assert (force >= 0.0).all()
    assert strain[taut] == pytest.approx(asked[taut], abs=1e-9)
    assert (asked[~taut] <= LAW.eps_L * fraction[~taut] + 1e-9).all()  # shorter than unloaded
    assert fraction.max() > 0.05


def test_slack_wire_leaves_the_beam_alone() -> None:
    """With more slack than the beam moves there is no difference to no wire."""
    without = simulate(
        Machine(mechanism=BeamMotor(**SLOW)), {"motor": Constant(level=3.0)}, 1.0, step=5e-4, samples=101
    )
    waves = {"motor": Constant(level=3.0), "drive": Constant(level=HOT)}
    with_wire = simulate(coupled(0.1, hot=True), waves, 1.0, step=5e-4, samples=101)
    assert with_wire["displacement"] == pytest.approx(without["displacement"], abs=1e-12)


def test_wire_takes_energy_in_a_closed_isothermal_cycle() -> None:
    """∮ F_w dx over cycles of the displacement is the loop of the law, whatever the lever."""
    motor = coupled(0.015).mechanism
    assert isinstance(motor, BeamMotor)
    section = math.pi / 4 * 0.375e-3**2
    for reach in (0.03, 0.05):
        x = np.concatenate([np.linspace(0.0, reach, 400), np.linspace(reach, 0.0, 400)[1:]])
        path = np.array([motor.path(floats, value) for value in x.tolist()])
        strain = np.maximum(-0.015 + path / LENGTH - 1.0, 0.0)
        legs = [PathLeg(strain=float(value), steps=1) for value in strain[1:]]
        stress = np.array(material_point(LAW, legs, start=(0.0, HOT))["stress"])
        pulls = [
            motor.supply(floats, [a, 0.0, 0.0], [s * section], [0.0] * 3)[0]
            for a, s in zip(x.tolist(), stress.tolist(), strict=True)
        ]
        work = np.trapezoid(pulls, x)
        loop = np.trapezoid(stress, strain) * section * LENGTH
        assert work == pytest.approx(-loop, rel=1e-3, abs=1e-9)
        assert loop > (0.02 if reach == 0.05 else -1e-9)


def test_wire_takes_energy_in_every_cycle_of_a_run() -> None:
    """Hot and at a constant temperature, from rest to rest of the tip at its lowest point."""
    run = driven()
    x, force = np.array(run["displacement"]), np.array(run["force"])
    motor = coupled(0.015).mechanism
    assert isinstance(motor, BeamMotor)
    path = np.array([motor.path(floats, value) for value in x.tolist()])
    lowest = np.flatnonzero((x[1:-1] < x[:-2]) & (x[1:-1] <= x[2:])) + 1
    lowest = lowest[x[lowest] < -0.005]
    works = [-np.trapezoid(force[a : b + 1], path[a : b + 1]) for a, b in pairwise(lowest)]
    assert len(works) > 10
    turned_over = max(
        np.trapezoid(force[a:b], np.cumsum(np.abs(np.diff(path[a : b + 1])))) for a, b in pairwise(lowest)
    )
    assert max(works) < 1e-3 * turned_over  # elastic cycles: 0, up to the sampling
    assert min(works) < -0.1 * turned_over


def test_a_wire_that_is_heated_pulls_the_beam_in() -> None:
    """Cold and slack at first; hot, it holds the tip where spring and wire balance."""
    system = coupled(-0.015)
    run = simulate(system, {"drive": Step(high=1.1, at=0.5)}, 25.0, step=0.02, samples=251)
    motor = system.mechanism
    assert isinstance(motor, BeamMotor)
    x, force = run["displacement"][-1], run["force"][-1]
    assert run["force"][0] == run["displacement"][0] == 0.0
    across = LENGTH * math.sin(motor.wire_angle) + x
    assert motor.stiffness * x == pytest.approx(-force * across / motor.path(floats, x), rel=1e-3)
    assert force > 10.0
