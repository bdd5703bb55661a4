"""Common parts of the calls about sweeps: requests, the folder of stores, and drawings."""
