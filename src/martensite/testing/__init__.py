"""What every part promises, as suites that anybody can run on a part of his own.

    from martensite import testing
    print(testing.check_conformance(MyLaw, "law"))

The tests of this package run the same suites on its own parts.
"""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
