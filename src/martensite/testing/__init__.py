"""Conformance suites for every kind of part. Users can run them on their parts.

from martensite import testing
print(testing.check_conformance(MyLaw, "law"))
"""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
