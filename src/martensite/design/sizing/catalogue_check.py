"""Check of the model against the maker's table: currents for 1 s and cooling times of every size.

The maker states room temperature, static air, a vertical wire, and a cooling time without the last 0.5 % of
deformation. The remaining conditions are chosen here:

- the load is a weight of the maker's pull stress, 172 MPa, in heating and cooling;
- room temperature is 22 °C; the wire is 100 mm long (h hardly depends on it);
- "contracts in 1 s" means 99 % of the strain between the pure phases at that load;
- 0.5 % of deformation is 0.5 % of the wire's length;
- the wire cools from the state at the end of that pulse.

Nothing is fitted to a size, so the ratios show the range of one set of numbers from 0.025 mm to 0.51 mm. Sources: the
cells of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from martensite.actuators.mechanisms.load_line import DeadWeight
from martensite.base.errors import SolveError
from martensite.design.sizing.cycle import STEPS, find_current, simulate_cooling
from martensite.design.sizing.request import ALLOYS
from martensite.design.sizing.statics import Strand, list_alloy_numbers
from martensite.physics.materials.wires import GRAVITY, Cell, WireCatalogue, WireSize, load_wires
from martensite.signals.step import Step
from martensite.simulate.api import simulate

LENGTH, AMBIENT, STRESS = 0.1, 295.15, 172e6
CONTRACTED = 0.99
"""Fraction of the full contraction that counts as contracted."""
LEFT = 0.005
"""Remaining strain at the end of the cooling time."""
PULSE = 1.0
"""[s]"""


@dataclass(frozen=True)
class CheckRow:
    """Prediction and catalogue of one size and alloy."""

    size: str
    alloy: str
    current: float
    """Current that contracts the wire in 1 s [A]."""
    current_cell: Cell
    cooling: float | None
    """Cooling time [s]; None if the wire does not cool so far."""
    cooling_cell: Cell
    loss_share: float
    """Fraction of the electrical energy of the pulse that is lost to the air."""
    stored_share: float
    """Electrical energy of the catalogue's 1 s pulse over the heat for 65 K and the transformation, without losses."""

    @property
    def current_ratio(self) -> float:
        """Return the predicted over the listed current."""
        return self.current / self.current_cell.value

    @property
    def cooling_ratio(self) -> float | None:
        """Return the predicted over the listed cooling time."""
        return None if self.cooling is None else self.cooling / self.cooling_cell.value


@dataclass(frozen=True)
class RatioSpread:
    """Smallest, mean and largest ratio."""

    least: float
    mean: float
    """Geometric mean."""
    most: float


def summarise_ratios(ratios: Sequence[float | None]) -> RatioSpread | None:
    """Return smallest, geometric mean and largest of the ratios that are not None."""
    numbers = [ratio for ratio in ratios if ratio is not None]
    if not numbers:
        return None
    mean = math.exp(math.fsum(math.log(ratio) for ratio in numbers) / len(numbers))
    return RatioSpread(min(numbers), mean, max(numbers))


def check_catalogue(
    catalogue: WireCatalogue | None = None,
    *,
    alloys: Sequence[str] = ALLOYS,
    stress: float = STRESS,
    ambient: float = AMBIENT,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> list[CheckRow]:
    """Predict every size of a catalogue (by default of Flexinol), alloy by alloy.

    A weight with a stress [Pa] is lifted in a room [K]. `progress` is called with the number of finished rows and their
    total. `stop` is called before each row; True ends the check.

    Raises:
        SolveError: no current contracts a wire in 1 s.
    """
    sizes = list((catalogue or load_wires()).sizes.values())
    rows: list[CheckRow] = []
    for alloy in alloys:
        for size in sizes:
            if stop is not None and stop():
                return rows
            rows.append(_check_row(size, Strand(size, alloy, LENGTH, ambient), stress))
            if progress is not None:
                progress(len(rows), len(alloys) * len(sizes))
    return rows


def _check_row(size: WireSize, strand: Strand, stress: float) -> CheckRow:
    system = strand.system(DeadWeight(mass=stress * size.section / GRAVITY))
    position = CONTRACTED * strand.reachable_strain(stress, stress) * strand.length
    current = find_current(system, position, PULSE, size.current.value)
    if current is None:
        raise SolveError(f"No current contracts Flexinol wire of {size.name} in {PULSE:g} s.")
    _, cooling = simulate_cooling(system, LEFT * strand.length, current, PULSE, strand.time_constant())
    cell = size.cooling_70 if strand.alloy == "70" else size.cooling_90
    run = simulate(system, Step(high=current), PULSE, step=PULSE / STEPS, samples=STEPS + 1)
    lost, given = (run.measure(f"integral({name})") for name in ("heat_loss", "power"))
    numbers = list_alloy_numbers(strand.alloy)
    taken = strand.mass * (65.0 * numbers["heat_capacity"] + numbers["latent_heat"])
    stored = size.current.value**2 * strand.resistance * PULSE / taken
    return CheckRow(size.name, strand.alloy, current, size.current, cooling, cell, lost / given, stored)
