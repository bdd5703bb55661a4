"""Public benchmark records of nonlinear system identification.

Published results are RMS errors of free simulation in millivolts, without the first 50 samples. Records are split as in
the publications:

    Silverbox (Wigren & Schoukens 2013), 610.35 Hz:
        multisine [40650:127400], the first 75 % for estimation, the rest for testing;
        arrow [100:40575] for testing, its first 32000 samples without extrapolation
    Wiener-Hammerstein 2009 (Schoukens, Suykens & Ljung), 51.2 kHz:
        [5200:184000], the first 100000 samples for estimation, the rest for testing
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from martensite.logs.datasets import describe_dataset, locate_file
from martensite.signals.sampling.sampled import Sampled

if TYPE_CHECKING:
    from martensite.signals.sampling.sampled import Numbers

SKIP = 50
"""Ignored samples at the start of a test."""
SILVERBOX_RATE = 1e7 / 2**14
"""Sampling rate [Hz]."""
WIENER_HAMMERSTEIN_RATE = 51200.0


def read_silverbox() -> dict[str, Sampled]:
    """Return the records `estimation`, `multisine`, `arrow` and `no extrapolation` [V].

    Raises:
        DataError: the data set `silverbox` is missing on this machine, or differs from the listed one.
    """
    import numpy as np

    path = locate_file("silverbox/SNLS80mV.csv")
    columns = np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1))
    whole = _build_record("silverbox", columns[:, 0], columns[:, 1], SILVERBOX_RATE)
    sines, arrow = whole.rows(40650, 127400), whole.rows(100, 40575)
    cut = 3 * len(sines) // 4
    return {
        "estimation": sines.rows(0, cut, "estimation"),
        "multisine": sines.rows(cut, None, "multisine"),
        "arrow": arrow.rows(0, None, "arrow"),
        "no extrapolation": arrow.rows(0, 32000, "no extrapolation"),
    }


def read_wiener_hammerstein() -> dict[str, Sampled]:
    """Return the records `estimation` and `test` [V].

    Raises:
        DataError: the data set `wiener-hammerstein-2009` is missing on this machine, or differs from the listed one.
    """
    import h5py
    import numpy as np

    name = "wiener-hammerstein-2009"
    parts: list[Numbers] = []
    for file in describe_dataset(name).files:
        with h5py.File(locate_file(f"{name}/{file}")) as opened:
            parts.append(np.array([opened["u"], opened["y"]]))
    u, y = np.concatenate(parts, axis=1)
    whole = _build_record(name, u, y, WIENER_HAMMERSTEIN_RATE).rows(5200, 184000)
    return {"estimation": whole.rows(0, 100_000, "estimation"), "test": whole.rows(100_000, None, "test")}


def _build_record(name: str, u: Numbers, y: Numbers, rate: float) -> Sampled:
    return Sampled(name, 1.0 / rate, u, y, ("input",), ("output",), {"input": "V", "output": "V"})
