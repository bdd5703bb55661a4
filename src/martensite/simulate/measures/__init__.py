"""Measures of a run, such as the stroke or the maximum temperature, in one file each."""
