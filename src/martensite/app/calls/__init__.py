"""Calls of the bench, one file each: `answer(request, desk)` takes a table and gives one.

A call runs in a worker. It raises `MartensiteError` with a sentence for what it refuses. Long ones
send notes with `desk.tell` and look at `desk.stop`.
"""
