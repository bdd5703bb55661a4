"""Control engineering: tuning, margins, regulators, consistency of filters; in `martensite.design` and `.control`."""
