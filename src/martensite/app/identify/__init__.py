"""What the calls of the page Identify share: files, columns, scenarios, fits."""
