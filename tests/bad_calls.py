"""Calls that misbehave, for tests of those that look after workers."""

import sys
from pathlib import Path

CALLS = {
    "run": "def answer(request, desk):\n    return {'echo': request}\n",
    "die": "import os, signal\n"
    "def answer(request, desk):\n    os.kill(os.getpid(), getattr(signal, request['signal']))\n",
    "leave": "def answer(request, desk):\n    raise SystemExit\n",
    "crash": "import ctypes\ndef answer(request, desk):\n    ctypes.string_at(0)\n",
    "hang": "import time\ndef answer(request, desk):\n    desk.tell({'begun': True})\n    time.sleep(600)\n",
    "stopped": "def answer(request, desk):\n    desk.tell({'begun': True})\n"
    "    desk.stop.wait(600)\n    return {'best': 'so far'}\n",
    "hungry": "def answer(request, desk):\n    kept = []\n    while True:\n        kept.append(bytearray(2**24))\n",
    "bug": "def answer(request, desk):\n    return 1 / request['zero']\n",
    "full": "import errno\ndef answer(request, desk):\n    raise OSError(errno.ENOSPC, 'No space left on device')\n",
    "prints": "def answer(request, desk):\n    print('not a message')\n    return {'fine': True}\n",
    "garbage": "import os, martensite.app.worker as worker\n"
    "def answer(request, desk):\n"
    "    line = bytes(request['line'], 'utf-8')\n"
    "    desk.tell.__closure__[0].cell_contents._out.write(line + b'\\n')\n"
    "    desk.tell({})\n    return {}\n",
    "huge": "def answer(request, desk):\n    return {'text': 'x' * request['size']}\n",
    "family": "import subprocess, sys, time\n"
    "def answer(request, desk):\n"
    "    child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'],\n"
    "                             pass_fds=())\n"
    "    desk.tell({'child': child.pid})\n    time.sleep(600)\n",
    "many": "def answer(request, desk):\n"
    "    for k in range(request['notes']):\n        desk.tell({'k': k})\n    return {'k': k}\n",
    "tree": "def answer(request, desk):\n    return {'none': float('nan'), 'n': [float('inf'), 1]}\n",
}
MAIN = """import sys
sys.path.insert(0, {folder!r})
from martensite.app import routes, worker
routes.CALLS, worker.MEMORY = "bad_calls_made", 2**29
routes.ROUTES = {{name: (name, "answer") for name in {names!r}}}
worker.main()
"""


def command(folder: Path) -> tuple[str, ...]:
    """What starts a worker that answers them; made in a folder."""
    package = folder / "bad_calls_made"
    package.mkdir(exist_ok=True)
    (package / "__init__.py").write_text("")
    for name, text in CALLS.items():
        (package / f"{name}.py").write_text(text)
    main = folder / "worker_of_tests.py"
    main.write_text(MAIN.format(folder=str(folder), names=list(CALLS)))
    return sys.executable, str(main)
