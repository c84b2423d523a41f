"""Everyday commands and pages use nothing that Windows' Python lacks: forks, signals of Unix."""

import subprocess
import sys
from pathlib import Path

LACKING = ("resource", "fcntl", "termios", "pwd", "grp", "tty", "pty", "syslog")
"""Modules that the standard library documents as of Unix alone."""
CALLS = ("fork", "killpg", "setsid", "getuid", "waitid", "geteuid")
SIGNALS = ("SIGALRM", "SIGKILL", "SIGHUP", "SIGXCPU", "alarm", "setitimer")
RUNS = f"""
import importlib.abc, os, signal, sys

class Lacking(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name in {LACKING}:
            raise ModuleNotFoundError(f"No module named '{{name}}'", name=name)

for name in {LACKING}:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Lacking())
import subprocess  # the standard library's own asks what there is
for name in {CALLS}:
    delattr(os, name)
for name in {SIGNALS}:
    delattr(signal, name)
from autodb.cli import main
served = sys.argv[1:]
for line in sys.stdin.read().splitlines():
    sys.argv = ["autodb", *line.split()]
    try:
        main()
    except SystemExit as ended:
        if ended.code:
            raise SystemExit(f"{{line}}: {{ended.code}}")
if served:
    from autodb.files.job import read_job
    from autodb.web.app import make_app
    from autodb.web.http.settings import Settings
    from autodb.web.receive.apart import ProgramToPredict
    from autodb.web.receive.children import Children
    from fastapi.testclient import TestClient
    from pathlib import Path
    url, job = served
    with TestClient(make_app(Settings(url)), base_url="http://localhost") as client:
        print(client.get("/").status_code, client.get("/machines/lathe-1").status_code)
    try:
        Children(url).do(ProgramToPredict("lathe-1", read_job(Path(job)), Path(job)), str, None)
    except Exception as error:
        print(error)
"""


def test_everyday_commands_run_without_what_unix_alone_has(
    tmp_path: Path, sample_jobs: Path
) -> None:
    source = sample_jobs / "stepped_shaft"
    week = source / "recordings" / "shop-week-1.csv"
    lines = (
        "--help",
        "init",
        "machine add lathe-1",
        f"import {week}",
        "lookup --material C45 --tool CNMG120408 --diameter 50 --depth 2 --feed 0.25 --speed 220",
        f"predict {source / 'job.toml'}",
    )
    done = subprocess.run(
        [sys.executable, "-c", RUNS, "sqlite:///autodb.sqlite3", str(source / "job.toml")],
        input="\n".join(lines), text=True, cwd=tmp_path, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert "new cuts" in done.stdout
    assert "95 % intervals" in done.stdout
    *_, pages, refusal = done.stdout.splitlines()
    assert pages == "200 200"
    assert "a service reads files on Unix alone" in refusal
