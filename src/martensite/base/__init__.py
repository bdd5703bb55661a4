"""Base of the package: parameters, names, units, errors, files."""
