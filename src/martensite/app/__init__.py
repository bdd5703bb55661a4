"""Web bench: a local page over the same parts as the command line.

The server (Starlette) hands out the page and passes calls on; it computes nothing and imports nothing heavy. Separate
processes (`worker`) compute the answers to calls (`routes`) in JSON. Quick calls run in a small pool (`worker_pool`).
Each long call runs in a separate process that reports progress and can be stopped (`jobs`).
"""
