"""`python -m tests.by_hand.fuzz TARGET SECONDS`: look for bytes that break what reads them.

Guided by coverage (atheris, extra `fuzz`). What leads somewhere new is kept in the corpus, the
fewest and shortest that lead as far. What breaks it is printed, and written to the working folder
as `crash-…`.
"""

import logging
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["autodb", "tomllib", "python_multipart"]):
    from tests.helpers.fuzzed import CORPUS, TARGETS

BOUNDS = ("-max_len=2048", "-timeout=10", "-rss_limit_mb=4096")
"""Bytes, and the seconds and MB that they may take."""
AGAIN = "AUTODB_FUZZ_AGAIN"
"""Names what libFuzzer runs to begin itself again."""


def fuzz(name: str, options: list[str]) -> None:
    """Fuzz a target with options of libFuzzer; ends the process."""
    target = TARGETS[name]
    logging.disable()
    root = Path(tempfile.mkdtemp(prefix="autodb-fuzz-", dir="/dev/shm"))

    def once(data: bytes) -> None:
        with tempfile.TemporaryDirectory(dir=root) as folder:
            target(data, Path(folder))

    atheris.Setup([os.environ[AGAIN], *options], once)
    atheris.Fuzz()


def main(name: str, seconds: str) -> int:
    """Fuzz for so long, then keep of what was there and what was found what is needed."""
    kept = CORPUS / name
    with tempfile.TemporaryDirectory(prefix="autodb-corpus-") as folder:
        again, found, needed = (Path(folder) / one for one in ("again", "found", "needed"))
        again.write_text(f'#!/bin/sh\nexec {sys.executable} -m tests.by_hand.fuzz {name} -- "$@"\n')
        again.chmod(0o755)
        environment = {**os.environ, AGAIN: str(again)}
        found.mkdir()
        needed.mkdir()
        looking = [str(again), f"-max_total_time={seconds}", *BOUNDS, str(found), str(kept)]
        broke = subprocess.run(looking, env=environment, check=False).returncode
        merging = [str(again), "-merge=1", *BOUNDS, str(needed), str(kept), str(found)]
        subprocess.run(merging, env=environment, check=True)
        shutil.rmtree(kept)
        shutil.copytree(needed, kept)
    return broke


if __name__ == "__main__":
    if sys.argv[2] == "--":
        fuzz(sys.argv[1], sys.argv[3:])
    sys.exit(main(sys.argv[1], sys.argv[2]))
