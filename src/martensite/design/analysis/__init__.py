"""Speed and energy of a plant or a loop."""
