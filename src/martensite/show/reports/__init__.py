"""Reports: what was found, with its figures, as a page to read or to print."""
