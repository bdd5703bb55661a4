"""Physics of the material: laws, heat, resistance, material parameters."""
