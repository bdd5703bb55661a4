"""Calls of the bench: functions of a request and a desk that give a table.

A call runs in a worker; `martensite.app.routes` names them all. It raises `MartensiteError` with a
sentence for what it refuses. Long ones send notes with `desk.tell` and look at `desk.stop`.
"""
