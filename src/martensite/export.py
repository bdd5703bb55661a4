"""Ways out: martensite elements in the programs of others.

They are the distribution `martensite-export`, which is imported when a name of it is first used.
"""

from martensite.base.lazy import forward_names

__getattr__, __dir__ = forward_names("martensite_export")
