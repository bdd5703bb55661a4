"""What every part promises, as suites that anybody can run on a part of his own.

    from martensite import testing
    print(testing.check_conformance(MyLaw, "law"))

The tests of this package run the same suites on its own parts.
"""

from martensite.testing.conformance import (
    Conformance,
    ConformanceError,
    Finding,
    check_conformance,
    check_material,
    check_target,
    find_parts,
)
from martensite.testing.examples import build_example, list_variants

__all__ = [
    "Conformance",
    "ConformanceError",
    "Finding",
    "build_example",
    "check_conformance",
    "check_material",
    "check_target",
    "find_parts",
    "list_variants",
]
