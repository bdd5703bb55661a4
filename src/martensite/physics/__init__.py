"""The material: laws, heat, resistance, numbers of materials."""
