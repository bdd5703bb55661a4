"""Control: sensors, observers, controllers, supervisors and faults, closed in a loop."""
