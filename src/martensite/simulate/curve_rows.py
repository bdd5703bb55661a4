"""Rows for curves: samples and accepted steps of a run, with all peaks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from martensite.simulate.result import Result


def add_step_rows(result: Result) -> Result:
    """Return a single run with additional rows at its accepted steps, on both sides of jumps.

    Other columns and profiles are interpolated linearly between samples.
    """
    if result.track is None or result.variants is not None:
        return result
    samples = result.times
    steps, own = result.list_rows()
    times = np.concatenate([steps, samples])
    order = np.argsort(times, kind="stable")
    times = times[order]
    columns = {name: np.interp(times, samples, column) for name, column in result.columns.items()}
    for name in own.keys() & columns.keys():
        columns[name] = np.concatenate([own[name], result[name]])[order]
    profiles = {
        name: [np.interp(times, samples, cell).tolist() for cell in cells] for name, cells in result.profiles.items()
    }
    full_result = replace(result, times=times, columns=columns, profiles=profiles)
    vars(full_result)["track"] = result.track  # computed once
    return full_result
