"""Control: sensors, observers, controllers, supervisors and faults, closed in a loop."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
