"""Figures of results: time series, hysteresis loops, measured records beside them."""
