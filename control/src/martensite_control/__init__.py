"""Control engineering: tuning, regulators, consistency of filters; offered in `martensite.design` and `.control`."""
