from martensite.physics.materials.base import material_names as material_names
from martensite.physics.materials.wires import load_wires as load_wires
from martensite.scenario.compare import compare_with_record as compare_with_record
from martensite.scenario.public_benchmarks import SKIP as SKIP
from martensite.scenario.public_benchmarks import read_silverbox as read_silverbox
from martensite.scenario.public_benchmarks import read_wiener_hammerstein as read_wiener_hammerstein
from martensite.scenario.sampled_files import read_sampled as read_sampled
from martensite.scenario.sampled_files import write_sampled as write_sampled
from martensite.scenario.scenario import read_scenario as _read_scenario
from martensite.scenario.staircase import reduce_to_plateaus as reduce_to_plateaus
from martensite.scenario.staircase import supply_offset as supply_offset
from martensite.scenario.staircase import unwrap_counter as unwrap_counter
from martensite.scenario.tables import read_table as read_table

read_scenario = _read_scenario
