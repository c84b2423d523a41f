"""`python -m docs.make`: every figure and printed output, commands, terms, tables of proofs.

What needs recordings that are not part of this program is left as it is where they are not.
"""

import os
import shutil
import tempfile
from pathlib import Path

from docs.make import (
    api,
    blocks,
    commands,
    day,
    emps,
    field,
    frames,
    homes,
    house,
    pair_peers,
    peers,
    proofs,
    real_axes,
    standing,
    sugeno,
    summary,
    terms,
    turning,
    weeks,
)

DOCS = Path(__file__).parent.parent
ROOT = DOCS.parent
SHARED = Path(os.environ.get("AUTODB_SHARED", ROOT.parent / "shared")) / "data"
EMPS = SHARED / "emps" / "DATA_EMPS.mat"
TURNING = SHARED / "vicomtech_turning_wear" / "Dataset_Machine_tool_wear.csv"
REAL_CASES = SHARED / "real"
JOBS = ROOT / "sample_jobs"
SAMPLE = (
    *sorted((JOBS / "stepped_shaft" / "recordings").iterdir()),
    JOBS / "stepped_shaft" / "job.toml",
    JOBS / "stepped_shaft" / "machine.toml",
)
REAL = (EMPS, TURNING)
REAL_PAGE = DOCS / "tutorial.md"
SAMPLE_PAGES = tuple(sorted((DOCS / "how-to").glob("*.md")))
COMMANDS_PAGE = DOCS / "commands.md"
TERMS_PAGE = DOCS / "terms.md"
LIBRARY_PAGE = DOCS / "library.md"
HOMES_PAGE = DOCS / "how-to" / "decide.md"


def main() -> None:
    """Make everything whose data are here, and say what was left."""
    COMMANDS_PAGE.write_text(commands.filled(COMMANDS_PAGE.read_text("utf-8")), "utf-8")
    LIBRARY_PAGE.write_text(api.filled(LIBRARY_PAGE.read_text("utf-8")), "utf-8")
    TERMS_PAGE.write_text(terms.filled(TERMS_PAGE.read_text("utf-8")), "utf-8")
    HOMES_PAGE.write_text(homes.filled(HOMES_PAGE.read_text("utf-8")), "utf-8")
    for page in proofs.PAGES:
        page.write_text(proofs.filled(page.read_text("utf-8")), "utf-8")
    for page, filled in (
        (peers.PAGE, peers.filled),
        (field.PAGE, field.filled),
        (pair_peers.PAGE, pair_peers.filled),
        (proofs.INDEX, proofs.index_filled),
        (standing.PAGE, standing.filled),
        (sugeno.PAGE, sugeno.filled),
        (summary.PAGE, summary.filled),
    ):
        page.write_text(filled(page.read_text("utf-8")), "utf-8")
    frames.draw()
    house.draw()
    day.draw()
    weeks.draw()
    for page in SAMPLE_PAGES:
        page.write_text(made(page, SAMPLE), "utf-8")
    draw_recordings()


def draw_recordings() -> None:
    """Make what needs recordings that are not part of this program, and say what was left."""
    if REAL_CASES.exists():
        real_axes.draw(REAL_CASES)
    else:
        print(f"figures of proofs/real.md are left as they are: no {REAL_CASES}")
    missing = [path for path in REAL if not path.exists()]
    if missing:
        print(f"{REAL_PAGE.name} and its figures are left as they are: no {missing[0]}")
        return
    REAL_PAGE.write_text(made(REAL_PAGE, REAL), "utf-8")
    emps.draw(EMPS, JOBS / "emps" / "columns.toml")
    turning.draw(TURNING, JOBS / "vicomtech_turning_wear" / "columns.toml")


def made(page: Path, files: tuple[Path, ...]) -> str:
    """Return the text of a page with its commands run in a fresh folder that holds ``files``."""
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            shutil.copyfile(file, Path(folder) / file.name)
        return blocks.played(page.read_text("utf-8"), Path(folder))


if __name__ == "__main__":
    main()
