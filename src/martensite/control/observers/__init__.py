"""Observers estimate quantities without a sensor."""
