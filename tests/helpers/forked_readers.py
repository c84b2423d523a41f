"""Processes that read what was sent, forked off one that has loaded what they need.

A service starts a Python for each, which loads for a second before it reads. Tests that ask what
becomes of what was sent take theirs from here: the same program, under the same bounds, with the
same status where it is killed. Of Linux alone, where a process takes in those that lost theirs.
"""

import array
import ctypes
import json
import os
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO, Any

from autodb.web.receive.children import COMMAND, THREADS

SUBREAPER = 36
"""PR_SET_CHILD_SUBREAPER of Linux' prctl: to whom a process is given that has lost its parent."""
FORKS = """
import gc, json, os, socket, sys
gc.disable()
from autodb.web.receive import apart
from autodb.agent.answer.pooled import pooling
from autodb.agent.operate import deciding, receiving, refreshing
from autodb.readers import text
from autodb.reports import explanation, recorded
gc.enable(); gc.freeze()
asks = socket.socket(fileno=int(sys.argv[1]))

def work(files, said, env, folder):
    os.setsid()
    for number, file in enumerate(files):
        os.dup2(file, number)
    os.environ.clear(); os.environ.update(env); os.chdir(folder)
    os.write(said, b"%d" % os.getpid()); os.close(said); asks.close()
    code = 0
    try:
        apart.main()
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
        code = 1
    sys.stderr.flush()
    os._exit(code)

while True:
    message, files, *_ = socket.recv_fds(asks, 1 << 16, 3)
    if not message:
        break
    heard, said = os.pipe()
    if (between := os.fork()) == 0:
        if os.fork() == 0:
            os.close(heard)
            work(files, said, *json.loads(message))
        os._exit(0)
    os.close(said)
    pid = os.read(heard, 99)
    os.waitpid(between, 0)
    for file in (*files, heard):
        os.close(file)
    asks.send(pid)
"""
"""Forks twice, so that who asked can wait for what it asked for."""


class Forked:
    """A process that was forked; as much of a ``subprocess.Popen`` as is asked of one."""

    def __init__(self, pid: int, stdin: IO[bytes], stdout: IO[bytes]) -> None:
        self.pid, self.stdin, self.stdout = pid, stdin, stdout
        self.returncode: int | None = None

    def wait(self) -> int:
        """Return its status, once it has ended."""
        if self.returncode is None:
            self.returncode = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self.returncode


class ForkedReaders:
    """Stands for the module ``subprocess`` where readers are started; begins at the first."""

    PIPE = subprocess.PIPE

    def __init__(self) -> None:
        self._forks: subprocess.Popen[bytes] | None = None
        self._asks: socket.socket | None = None
        self._lock = threading.Lock()

    def Popen(self, command: Any, **more: Any) -> Any:
        """Return a process that reads, or what another command starts."""
        if command != COMMAND or sys.platform != "linux":
            return subprocess.Popen(command, **more)
        (theirs_in, ours_in), (ours_out, theirs_out) = os.pipe(), os.pipe()
        try:
            files = (theirs_in, theirs_out, more["stderr"].fileno())
            with self._lock:
                pid = self._forked(json.dumps([more["env"], str(Path.cwd())]).encode(), files)
        finally:
            os.close(theirs_in)
            os.close(theirs_out)
        return Forked(pid, os.fdopen(ours_in, "wb"), os.fdopen(ours_out, "rb"))

    def _forked(self, message: bytes, files: tuple[int, ...]) -> int:
        """Return the number of a process that has files for its input, output and errors."""
        if self._asks is None:
            self._asks = self._begun()
        prctl = ctypes.CDLL(None).prctl
        prctl(SUBREAPER, 1, 0, 0, 0)
        try:
            sent = (socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", files))
            self._asks.sendmsg([message], [sent])
            return int(self._asks.recv(99))
        finally:
            prctl(SUBREAPER, 0, 0, 0, 0)

    def _begun(self) -> socket.socket:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._forks = subprocess.Popen(
                [sys.executable, "-P", "-c", FORKS, str(theirs.fileno())],
                pass_fds=[theirs.fileno()], env=os.environ | THREADS,
            )  # fmt: skip
        return ours

    def end(self) -> None:
        """Have no more forked."""
        if self._asks is not None and self._forks is not None:
            self._asks.close()
            self._forks.wait()
