"""Common functions of the calls of the page Identify: files, columns, scenarios, fits."""
