"""Identification: from measurements to parameters, with what the data cannot determine."""
