"""Records at equal intervals: cut, resampled, detrended, averaged over periods, from tables."""
