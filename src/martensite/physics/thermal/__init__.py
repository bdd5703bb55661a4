"""Heat loss of an element to its surroundings: one file per model."""
