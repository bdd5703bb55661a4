"""Controllers: what turns a reference and readings into the signal of a drive."""
