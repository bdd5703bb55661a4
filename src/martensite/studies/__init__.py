"""Studies: what each answers, and where they are found; those of papers are a package apart."""
