"""Elements: a law, a heat balance, a resistance and a geometry, coupled by numbers."""
