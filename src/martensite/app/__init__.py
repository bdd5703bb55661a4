"""The web bench: a local page over the same parts as the command line.

The server (Starlette) hands out the page and passes calls on; it computes nothing and imports
nothing heavy. What is computed is computed in processes of its own (`worker`), which answer calls
(`routes`) in JSON: quick ones from a small pool (`worker_pool`), long ones each in a
process of its own that tells how far it is and can be stopped (`jobs`).
"""
