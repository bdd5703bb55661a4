"""Boards: firmware around an exported loop, the link to it, logs and experiments; offered in `martensite.hardware`."""
