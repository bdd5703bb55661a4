"""Writes the result pages of the laboratories, with the commit that they belong to.

In the folder `tests`:

    python -m laboratory                      both pages
    python -m laboratory faults --share 0.02  that of faults, with so many of the trials of a whole run
    python -m laboratory accuracy             that of the accuracy of runs
    python -m laboratory measures             its second part: measures and alarms of random scenarios
    python -m laboratory repeat               the scenarios of this part whose error is above the bound
    python -m laboratory wires                its first part: random wires beside other equations
"""

from __future__ import annotations

import argparse

from laboratory import faults, table

PAGES = ("faults", "accuracy")
"""Laboratories whose pages are written if none is named."""

if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("pages", nargs="*", help="faults, accuracy, measures, repeat, wires; both pages if not given")
    parser.add_argument("--share", type=float, default=1.0, help="fraction of the trials of a whole run")
    parser.add_argument("--processes", type=int, default=1, help="trials of accuracy at the same time")
    asked = parser.parse_args()
    writers = {
        "accuracy": table.write,
        "measures": table.write_measures,
        "repeat": table.repeat,
        "wires": table.write_wires,
    }
    for name in asked.pages or PAGES:
        if name == "faults":
            faults.write(asked.share)
        else:
            writers[name](asked.share, asked.processes)
