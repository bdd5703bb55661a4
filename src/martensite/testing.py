"""What every part promises, as suites that anybody can run on a part of his own.

They are the distribution `martensite-testing`, which is imported when a name of it is first used.
"""

from martensite.base.lazy import forward_names

__getattr__, __dir__ = forward_names("martensite_testing")
