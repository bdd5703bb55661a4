"""Web bench: a local page for the same parts as the command line.

The server (Starlette) serves the page and passes calls (`routes`) on to processes (`worker`): quick calls to a small
pool (`worker_pool`), each long call to a separate process with progress notes (`jobs`).
"""
