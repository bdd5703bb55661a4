"""Commands of `martensite`, found by their files: one file per command, one folder per group."""
