"""Conformance suites for every kind of part, which users can run on their parts.

    from martensite import testing
    print(testing.check_conformance(MyLaw, "law"))

The tests of this package run the same suites on its own parts.
"""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
