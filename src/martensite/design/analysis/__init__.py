"""How fast a plant or a loop is, and at what energy."""
