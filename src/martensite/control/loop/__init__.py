"""Virtual bench: a plant with sensors, observers, controllers, supervisor and faults."""
