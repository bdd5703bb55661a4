"""Scenarios and other files: measured tables and data sets, results as netCDF, citations."""
