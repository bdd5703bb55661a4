"""Writes the result pages of the laboratories, with the commit that they belong to.

In the folder `tests`:

    python -m laboratory                      both pages
    python -m laboratory faults --share 0.02  that of faults, with so many of the trials of a whole run
    python -m laboratory accuracy             that of the accuracy of runs
"""

from __future__ import annotations

import argparse

from laboratory import faults, table

PAGES = {"faults": lambda share: faults.write(share), "accuracy": lambda share: table.write(share)}
"""Laboratory -> what makes its trials and writes its page."""

if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("pages", nargs="*", help=", ".join(PAGES))
    parser.add_argument("--share", type=float, default=1.0)
    asked = parser.parse_args()
    for name in asked.pages or PAGES:
        PAGES[name](asked.share)
