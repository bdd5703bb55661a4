"""The virtual bench: a plant with its sensors, observers, controllers, supervisor, faults."""
