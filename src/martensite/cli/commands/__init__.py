"""Commands of `martensite`: one file per command, one folder per group."""
