"""Calls of the bench: functions of a request and a desk that return a table.

A call runs in a worker; `martensite.app.routes` names all calls. It raises `MartensiteError` to refuse a request. Long
calls send notes with `desk.tell` and check `desk.stop`.
"""
