"""Files: scenarios, measured tables and data sets, results as netCDF, citations."""
