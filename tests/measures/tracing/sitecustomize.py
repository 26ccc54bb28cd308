"""Notes each of our functions that runs, in any Python that finds this file on its path, also ROS's: for walk.py.

`IMPROV_WALK` names the folder for the notes, `IMPROV_WALKED` the checkout. Standard library only, Python 3.10.
"""

from __future__ import annotations

import atexit
import os
import sys
import threading
import time
from pathlib import Path
from types import FrameType

_FOLDER, _ROOT = os.environ.get("IMPROV_WALK", ""), os.environ.get("IMPROV_WALKED", "") + os.sep
_OURS = ("improv_core/", "improv_ls/")
_OUTPUTS = ("outputs/simulator/simulator.py", "outputs/ros/output.py", "sinks/simulator.py", "sinks/ros.py")
_calls: list[str] = []
_names: dict[str, str] = {}


def _note(frame: FrameType, event: str, _: object) -> None:
    """Called by the interpreter whenever a function begins."""
    if event != "call":
        return
    code = frame.f_code
    name = _names.get(code.co_filename)
    if name is None:
        short = code.co_filename.removeprefix(_ROOT)
        name = _names[code.co_filename] = short if short.startswith(_OURS) else ""
    if not name:
        return
    now = time.monotonic_ns()
    _calls.append(f"{now}\t{threading.get_ident()}\t{name}\t{code.co_firstlineno}\n")
    twist = frame.f_locals.get("twist") if code.co_name == "send" and name.endswith(_OUTPUTS) else None
    if twist is not None:
        moves = any((twist.x, twist.y, twist.z, twist.yaw))
        os.write(_sent, f"{now}\t{'moves' if moves else 'zero'}\t{name}\n".encode())


def _write_down() -> None:
    count = len(_calls)
    with Path(_FOLDER, f"{os.getpid()}.calls").open("a", encoding="utf-8") as file:
        file.writelines(_calls[:count])
    del _calls[:count]


def _keep_writing() -> None:
    while True:
        time.sleep(0.4)  # not while a walk is followed: a save takes milliseconds
        _write_down()


if _FOLDER:
    _sent = os.open(f"{_FOLDER}/sent", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    _about = f"{threading.get_ident()} {' '.join(sys.orig_argv)}"
    Path(_FOLDER, f"{os.getpid()}.process").write_text(_about, encoding="utf-8")
    threading.Thread(target=_keep_writing, daemon=True).start()
    atexit.register(_write_down)
    threading.setprofile(_note)
    sys.setprofile(_note)
