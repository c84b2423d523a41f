"""`python -m tests.by_hand.hashes`: write the checksums of its files on PyPI into constraints.txt.

To be run after a version there has changed; `make hashes` then has pip check them.
"""

import json
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.request import Request, urlopen

from packaging.utils import (
    InvalidSdistFilename,
    InvalidWheelFilename,
    canonicalize_name,
    parse_sdist_filename,
    parse_wheel_filename,
)
from packaging.version import Version

CONSTRAINTS = Path(__file__).parents[2] / "constraints.txt"
INDEX = "https://pypi.org/simple"
FORM = "application/vnd.pypi.simple.v1+json"
AT_ONCE, WAIT_S = 8, 60.0
PINNED = re.compile(r"^([A-Za-z0-9._-]+)==(\S+)", re.MULTILINE)


def entry(pinned: tuple[str, str]) -> str:
    """Return a version with the checksums of its files, as pip reads them."""
    name, version = pinned
    asked = Request(f"{INDEX}/{canonicalize_name(name)}/", headers={"Accept": FORM})
    with urlopen(asked, timeout=WAIT_S) as answer:
        files = json.load(answer)["files"]
    known = sorted(
        {one["hashes"]["sha256"] for one in files if _version(one["filename"]) == Version(version)}
    )
    if not known:
        sys.exit(f"{name} {version}: no file of it on {INDEX}")
    return " \\\n    ".join([f"{name}=={version}", *(f"--hash=sha256:{one}" for one in known)])


def _version(file: str) -> Version | None:
    try:
        parse = parse_wheel_filename if file.endswith(".whl") else parse_sdist_filename
        return parse(file)[1]
    except (InvalidWheelFilename, InvalidSdistFilename):
        return None


def main() -> None:
    """Write the file anew, its comments above as they are."""
    text = CONSTRAINTS.read_text("utf-8")
    head = "".join(line for line in text.splitlines(keepends=True) if line.startswith("#"))
    with ThreadPoolExecutor(AT_ONCE) as several:
        entries = list(several.map(entry, PINNED.findall(text)))
    CONSTRAINTS.write_text(head + "\n".join(entries) + "\n", "utf-8")


if __name__ == "__main__":
    main()
