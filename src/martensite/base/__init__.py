"""What everything stands on: parameters, names, units, errors, files."""
