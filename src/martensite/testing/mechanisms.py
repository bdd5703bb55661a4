"""Suite for mechanisms at one instant: equilibrium, levers, energy, inertia.

Derivatives are compared with differences of the mechanism's functions.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.elements.base import Spring
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import AbstractMechanism, Column
from martensite.actuators.mechanisms.load_line import AbstractLoadLine, LoadLineReference
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.base.errors import UnitError
from martensite.base.units import find_dimensions
from martensite.kernels import floats
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace
from martensite.testing.conformance import require_condition

Numbers: TypeAlias = tuple[float, ...]
Array: TypeAlias = NDArray[np.float64]
FREE = np.linspace(-0.05, 0.05, 101).tolist()
"""Free elongations of the test spring [m]."""


def is_consistent(mechanism: AbstractMultibody) -> bool:
    """Return False for a mechanism that is kept for comparison and known to be inconsistent."""
    return getattr(mechanism, "coupling", "lagrange") == "lagrange"


def choose_places(mechanism: AbstractMultibody, share: float = 0.2) -> list[Numbers]:
    """Return four positions near home."""
    rng = np.random.default_rng(3)
    sizes = np.array([c.size for c in mechanism.coordinates()])
    home = np.array(mechanism.home(floats))
    return [tuple(home + share * sizes * rng.uniform(-1, 1, len(sizes))) for _ in range(4)]


def choose_rates(mechanism: AbstractMultibody) -> list[Numbers]:
    """Return four velocities."""
    sizes = [c.size for c in mechanism.coordinates()]
    return [tuple(s * math.sin(1 + i + 3 * k) for k, s in enumerate(sizes)) for i in range(4)]


def find_demand(mechanism: AbstractMultibody, *motion: Column) -> Array:
    """Return the demand for position, velocity and acceleration (zero if not given), without signals."""
    rest = (0.0,) * len(mechanism.coordinates())
    numbers = (tuple(motion[k]) if k < len(motion) else rest for k in range(3))
    signals = [0.0] * len(mechanism.signals())
    return np.array(mechanism.demand(floats, Motion(*numbers), signals))


def find_inertia(mechanism: AbstractMultibody, position: Column) -> Array:
    """Return the inertia matrix: the derivative of the demand by the acceleration."""
    rest = find_demand(mechanism, position)
    still, unit = [0.0] * len(rest), np.eye(len(rest)).tolist()
    return np.array([find_demand(mechanism, position, still, e) - rest for e in unit]).T


def check_interface(mechanism: AbstractMechanism) -> None:
    """A mechanism has a start force for each element, and SI units for all inputs and outputs."""
    forces, ports = mechanism.start_forces(floats), mechanism.ports()
    require_condition(len(forces) == len(ports), f"{len(forces)} start forces of {len(ports)}.")
    pulls = all(math.isfinite(force) and force >= 0.0 for force in forces)
    require_condition(pulls, f"The start forces are {forces} N; an element pulls, or is slack.")
    outputs = mechanism.outputs()
    require_condition(outputs, "It has no output: its first one is the stroke.")
    named = {name: output.unit for name, output in outputs.items()} | mechanism.signals() | mechanism.initial_numbers()
    for name, unit in named.items():
        require_condition(_is_unit(unit), f"`{name}` is in `{unit}`, which is no unit of SI.")
    scales = mechanism.convergence_scales()
    own = set(scales) <= set(outputs) and all(scale > 0.0 for scale in scales.values())
    require_condition(own, f"`convergence_scales` is {scales}; it needs outputs of the mechanism, with ranges above 0.")


def _is_unit(unit: str) -> bool:
    try:
        find_dimensions(unit)
    except UnitError:
        return False
    return True


def check_pull(mechanism: AbstractLoadLine) -> None:
    """A load line never pushes, and its force does not grow as the element gets longer."""
    for compliance in (1e-6, 1e-4, 1e-2):
        assembly = LoadLineReference(0.004)
        forces = [mechanism.force(floats, assembly, Spring(free, compliance)) for free in FREE]
        require_condition(min(forces) >= 0.0, f"The force falls to {min(forces):.4g} N: it pushes.")
        grows = np.diff(forces) > 1e-12
        there = 1e3 * FREE[int(np.argmax(grows))]
        require_condition(not grows.any(), f"The force grows as the element gets longer, at {there:.1f} mm.")


def check_assembly(mechanism: AbstractLoadLine) -> None:
    """Under its start force a load line is in equilibrium, at position zero."""
    force = mechanism.start_force(floats)
    spring = Spring(0.003, 2e-4)
    elongation = spring.free + spring.compliance * force
    actual = mechanism.force(floats, LoadLineReference(elongation), spring)
    balanced = abs(actual - force) <= 1e-9 * (1.0 + abs(force))
    require_condition(balanced, f"Assembled with {force:.6g} N, it holds {actual:.6g} N.")
    zero = mechanism.position(floats, LoadLineReference(elongation), actual, elongation)
    require_condition(abs(zero) < 1e-12, f"As assembled it stands at {zero:.4g} instead of 0.")


def check_position(mechanism: AbstractLoadLine) -> None:
    """The position of a load line grows as the element shortens."""
    assembly, positions = LoadLineReference(0.01), list[float]()
    for free in np.linspace(0.009, 0.001, 50).tolist():
        force = mechanism.force(floats, assembly, Spring(free, 2e-4))
        positions.append(mechanism.position(floats, assembly, force, free + 2e-4 * force))
    require_condition((np.diff(positions) > 0.0).all(), "The position falls as the element shortens.")


def check_names(mechanism: AbstractMultibody) -> None:
    """A mechanism has one name per coordinate, and its convergence scales belong to its outputs."""
    coordinates, ports = mechanism.coordinates(), mechanism.ports()
    home = mechanism.home(floats)
    rest = Motion(tuple(home), (0.0,) * len(home), (0.0,) * len(home))
    names = {c.name for c in coordinates}
    require_condition(len(home) == len(names), f"{len(home)} numbers at home, but {len(names)} coordinates.")
    paths = mechanism.contraction(floats, home)
    require_condition(len(paths) == len(set(ports)), f"{len(paths)} paths, but {len(ports)} ports.")
    require_condition(max(map(abs, paths), default=0.0) < 1e-12, "At home a path is shortened already.")
    forces = len(mechanism.start_forces(floats))
    transmissions = len(mechanism.transmission(floats, rest))
    require_condition(forces == transmissions, f"{forces} start forces, but {transmissions} in `transmission`.")
    unknown = set(mechanism.convergence_scales()) - set(mechanism.outputs())
    require_condition(not unknown, f"It judges {', '.join(sorted(unknown))}, which it does not show.")
    require_condition(all(c.size > 0.0 for c in coordinates), "The size of a coordinate is not above zero.")
    dotted = [n for n in (*ports, *mechanism.outputs(), *mechanism.signals()) if "." in n]
    require_condition(not dotted, f"A name must have no dot, but {', '.join(dotted)} has.")


def check_equilibrium(mechanism: AbstractMultibody) -> None:
    """At home, under the start forces, demand equals supply."""
    home, forces = mechanism.home(floats), mechanism.start_forces(floats)
    require_condition(min(forces, default=0.0) >= 0.0, "A start force is below zero.")
    supplied = np.array(mechanism.supply(floats, home, forces, [0.0] * len(home)))
    demand = find_demand(mechanism, home)
    balanced = np.allclose(demand, supplied, rtol=1e-9, atol=1e-15)
    require_condition(balanced, f"At home it demands {demand}, but the start forces supply {supplied}.")


def check_levers(mechanism: AbstractMultibody) -> None:
    """The derivatives of the paths agree with differences."""
    for place in choose_places(mechanism):
        paths, exact = compute_jacobian(floats, mechanism.contraction, place)
        require_condition(paths == mechanism.contraction(floats, place), "A path depends on who asks.")
        for k, coordinate in enumerate(mechanism.coordinates()):
            h = 1e-5 * coordinate.size
            moved = ([*place[:k], place[k] + s * h, *place[k + 1 :]] for s in (1.0, -1.0))
            up, down = (np.array(mechanism.contraction(floats, q)) for q in moved)
            slopes = np.array([row[k] for row in exact])
            equal = np.allclose(slopes, (up - down) / (2.0 * h), rtol=1e-7, atol=1e-9)
            require_condition(equal, f"A path has a wrong slope in `{coordinate.name}`.")


def check_potential(mechanism: AbstractMultibody) -> None:
    """Static forces derive from an energy: ∂D_i/∂q_k is symmetric."""

    def static_demand(xp: Namespace, position: Column) -> Column:
        rest = (0.0,) * len(position)
        signals = [0.0] * len(mechanism.signals())
        return mechanism.demand(xp, Motion(tuple(position), rest, rest), signals)

    for place in choose_places(mechanism):
        stiffness = np.array(compute_jacobian(floats, static_demand, place)[1])
        apart = np.abs(stiffness - stiffness.T).max()
        symmetric = apart <= 1e-12 * np.abs(stiffness).max()
        require_condition(symmetric, f"At rest a way round gives energy: ∂D_i/∂q_k differs by {apart:.3g}.")


def check_inertia(mechanism: AbstractMultibody) -> None:
    """The inertia is positive definite and symmetric."""
    if not mechanism.moves and not find_inertia(mechanism, choose_places(mechanism)[0]).any():
        return
    for place in choose_places(mechanism):
        inertia = find_inertia(mechanism, place)
        least = np.linalg.eigvalsh(inertia + inertia.T).min()
        require_condition(least > 0.0, "It accelerates in some direction without a force.")
        if is_consistent(mechanism):
            apart = np.abs(inertia - inertia.T).max()
            require_condition(apart <= 1e-12 * np.abs(inertia).max(), "Its inertia is not symmetric.")


def check_gyration(mechanism: AbstractMultibody) -> None:
    """Forces quadratic in velocity only move energy: v·c = ½ v·(dM/dt) v."""
    if not is_consistent(mechanism):
        return
    rows = zip(choose_places(mechanism), choose_rates(mechanism), strict=True)
    for place, rate in rows:
        back = [-v for v in rate]
        both = find_demand(mechanism, place, rate) + find_demand(mechanism, place, back)
        even = 0.5 * both - find_demand(mechanism, place)
        ahead, behind = (
            find_inertia(mechanism, [q + s * v for q, v in zip(place, rate, strict=True)]) for s in (1e-5, -1e-5)
        )
        v = np.array(rate)
        change = 0.5 * v @ ((ahead - behind) / 2e-5) @ v
        size = np.abs(v) @ np.abs(find_inertia(mechanism, place)) @ np.abs(v)
        rounding = np.abs(v) @ np.abs(find_demand(mechanism, place))
        missing = abs(v @ even - change)
        conserved = missing <= 1e-8 * size + 2e-12 * rounding  # the inertia itself is a difference of demands
        require_condition(conserved, f"Motion at a constant rate makes {missing:.3g} W of its own.")


def check_damping(mechanism: AbstractMultibody) -> None:
    """Forces odd in velocity never drive the motion."""
    rows = zip(choose_places(mechanism), choose_rates(mechanism), strict=True)
    for place, rate in rows:
        back = [-v for v in rate]
        odd = 0.5 * (find_demand(mechanism, place, rate) - find_demand(mechanism, place, back))
        power = float(np.array(rate) @ odd)
        rounding = 1e-12 * float(np.abs(rate) @ np.abs(find_demand(mechanism, place)))
        require_condition(power >= -rounding, f"Friction drives the motion with {-power:.3g} W.")


def check_power(mechanism: AbstractMultibody) -> None:
    """The power of a motion is the change of its energy, plus dissipation, minus external power."""
    if not is_consistent(mechanism):
        return
    signals = [3.0 + k for k in range(len(mechanism.signals()))]
    places = [*choose_places(mechanism), *choose_places(mechanism, 3.3)]  # beyond end stops too
    for place, rate in zip(places, 2 * choose_rates(mechanism), strict=True):
        gain = [1.7 * v + 0.3 * c.size for v, c in zip(rate, mechanism.coordinates(), strict=True)]
        motion = Motion(place, rate, tuple(gain if mechanism.moves else [0.0] * len(rate)))
        change = find_energy_rate(mechanism, motion)
        if change is None:
            return
        taken = np.array(mechanism.dissipative(floats, motion))
        given = np.array(mechanism.external_forces(floats, motion, signals))
        needs = np.array(mechanism.demand(floats, motion, signals))
        size = float(np.abs(rate) @ np.abs(needs))
        missing = float(np.array(rate) @ (needs - taken + given)) - change
        require_condition(
            abs(missing) <= 1e-9 * size,
            f"Of {size:.3g} W that a motion demands, {missing:.3g} W are not in its energy.",
        )
        require_condition(np.array(rate) @ taken >= 0.0, "What is said to be dissipated drives the motion.")


def find_energy_rate(mechanism: AbstractMultibody, motion: Motion) -> float | None:
    """Return the rate of stored energy [W], without kinetic energy if massless; None without an `energy`."""
    if mechanism.energy(floats, motion) is None:
        return None

    def stored_energy(xp: Namespace, time: Column) -> Column:
        (q, v, a), (t,) = motion, time
        place = tuple(x + t * (y + 0.5 * t * z) for x, y, z in zip(q, v, a, strict=True))
        speed = tuple(y + t * z for y, z in zip(v, a, strict=True))
        energy = mechanism.energy(xp, Motion(place, speed, a))
        if energy is None:
            return [0.0]
        kinetic = energy.kinetic if mechanism.moves else 0.0
        return [energy.springs + energy.gravity + energy.magnetic + kinetic]

    return float(compute_jacobian(floats, stored_energy, [0.0])[1][0][0])
