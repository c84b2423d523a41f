"""Every command that writes, each in a shop where it has something to do.

`agent` and `serve` go on until they are stopped; what a kill of them leaves is tested by itself.
"""

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from autodb.assets import kit
from autodb.proofs.runs.keeping.forked import Step
from autodb.store import file_of, migrate, models, open_store, revisions

URL = "sqlite:///autodb.sqlite3"
MACHINE, OTHER = "lathe-1", "lathe-2"
OF = ("--machine", MACHINE)
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
NEWTONS_PER_AMPERE = 400.0
KNOWN, LATER = 8, 20
"""Cuts that the shop knows, and of a later recording: as many as a second is enough for."""
LARGE_CUTS, LARGE_VALUES = 40_000, 130
"""Cuts of another machine, and numbers of each: more than 100 MB in all."""
A_LATHE = """\
diameter = true
spindle = { max_speed_rpm = 4000 }
axes.x.limits = { travel_low_mm = -10, travel_high_mm = 160 }
axes.z.limits = { travel_low_mm = -5, travel_high_mm = 520 }
[setup]
tool = 3
spindle = "M4"
clearance_mm = 2
zero = { x_mm = 0, z_mm = 120 }
retract = { x_mm = 150, z_mm = 300 }
jaws = { z_mm = 60, diameter_mm = 200 }
"""
A_PART = """\
machine_compliance_mm_N = 3e-5
[bar]
diameter_mm = 24.0
length_mm = 120.0
modulus_MPa = 210000.0
[measured]
place_mm = [15.0, 35.0, 55.0, 75.0, 95.0, 115.0]
diameter_error_mm = [0.0388, 0.0401, 0.0451, 0.0578, 0.0806, 0.1134]
noise_mm = 0.002
"""
PASSES = ("refresh_pass", "inbox_file")
"""Which pass took which file in: two passes may each take some."""
DATED = ("20250101T000000Z", "20250102T000000Z", "20250103T000000Z")


@dataclass(frozen=True)
class Command:
    """A command line that writes, and what is done in the shop before it.

    ``again``: run a second time it writes once more, such as one more prediction. ``seldom``: it
    takes long, and its turn comes less often. ``shared``: tables in which two of it at once may
    share the work out otherwise than one does.
    """

    name: str
    words: Step
    before: tuple[Step, ...] = ()
    large: bool = False
    again: bool = False
    seldom: bool = False
    shared: tuple[str, ...] = ()


def furnish(folder: Path) -> None:
    """Put the files of a shop into a folder: recordings, a job, a part, machine files."""
    for path in (*sorted(RECORDINGS.iterdir()), RECORDINGS.parent / "job.toml"):
        shutil.copyfile(path, folder / path.name)
    shutil.copyfile(RECORDINGS.parent / "machine.toml", folder / "machine.toml")
    (folder / "lathe.toml").write_text(A_LATHE, encoding="utf-8")
    (folder / "part.toml").write_text(A_PART, encoding="utf-8")
    moves = pd.read_csv(folder / "air-moves.csv")
    load_N = NEWTONS_PER_AMPERE * 2.0 * np.sin(2.0 * np.pi * moves["t"] / 3.0)
    moves["z.current"] += load_N / NEWTONS_PER_AMPERE
    moves.assign(**{"force.z": -load_N}).to_csv(folder / "push.csv", index=False)
    inbox = folder / "in"
    inbox.mkdir()
    week = pd.read_csv(folder / "shop-week-2.csv")
    week.iloc[:LATER].to_csv(folder / "later.csv", index=False)
    pd.read_csv(folder / "shop-week-1.csv").iloc[:KNOWN].to_csv(folder / "week.csv", index=False)
    standard = pd.read_csv(folder / "standard-cuts.csv").drop(columns="tool")
    standard.to_csv(folder / "standard.csv", index=False)  # of no tool: nothing is learnt from it
    for name, rows in (("a.csv", slice(0, 5)), ("again.csv", slice(0, 5)), ("b.csv", slice(5, 10))):
        week.iloc[rows].to_csv(inbox / name, index=False)
    for ending in (".parquet", ".toml"):
        shutil.copyfile(folder / f"standard-cut-raw{ending}", inbox / f"raw{ending}")
    (inbox / "broken.csv").write_text("cut,t\n1,2\n", encoding="utf-8")


FIRST: tuple[Step, ...] = (
    ("init",),
    ("machine", "add", MACHINE),
    ("import", "standard.csv", "air-moves.csv", "week.csv", *OF),
    ("identify", "air-moves.csv", *OF),
    ("calibrate", *OF),
    ("refresh", *OF),
)
"""What was done in the shop before any of the commands."""


def grow() -> None:
    """Let another machine have so many cuts that the database of the folder is large."""
    store = open_store(URL)
    with store.writing() as session:
        session.add(models.Machine(name="mill-9", rotary_order=[]))
        session.flush()
        there = session.query(models.StoredRecording).count()
        machine = session.query(models.Machine).filter_by(name="mill-9").one().id
        session.add(models.StoredRecording(
            machine_id=machine, sha256="0" * 64, path="mill-9.csv", kind="cuts", rows=LARGE_CUTS,
            units={}, side={},
        ))  # fmt: skip
        session.flush()
        draw = np.random.default_rng(11)
        for first in range(0, LARGE_CUTS, 1000):
            session.bulk_insert_mappings(models.Cut.__mapper__, [
                {"recording_id": there + 1, "number": first + k, "conditions": {},
                 "measured": {f"v{i}": float(v) for i, v in enumerate(draw.random(LARGE_VALUES))}}
                for k in range(1000)
            ])  # fmt: skip
    store.close()


def _to_the_schema_before() -> None:
    migrate(URL, revisions()[-2])


def _without_a_database() -> None:
    file_of(URL).unlink()


def _with_dated_backups() -> None:
    Path("kept").mkdir()
    for stamp in DATED:
        shutil.copyfile("monday.sqlite3", f"kept/autodb-{stamp}.sqlite3")


WITHDRAW = ("withdraw", "3", *OF, "--why", "a worn edge")
MONDAY: Step = ("backup", "monday.sqlite3")
EXPLAINED: Step = ("explain", "later.csv", *OF, "--out", "answer")
PREDICTED: tuple[Step, ...] = (("predict", "job.toml", *OF), ("import", "in/a.csv", *OF))
MATCH = (
    "predictions", "match", *OF, "--recording", "4", "--prediction", "1", "--cut", "1=rough Ø56",
)  # fmt: skip
CHANGED: Step = (
    "edge", "changed", *OF, "--tool", "carbide insert", "--at", "2026-01-02T07:30+00:00",
)  # fmt: skip
COMMANDS = (
    Command("init", ("init",), (_without_a_database,)),
    Command("init of an earlier schema", ("init",), (_to_the_schema_before,)),
    Command("machine add", ("machine", "add", OTHER)),
    Command("machine update", ("machine", "update", MACHINE, "--file", "machine.toml")),
    Command("machine rename", ("machine", "rename", MACHINE, OTHER)),
    Command("machine retire", ("machine", "retire", MACHINE)),
    Command("import", ("import", "shop-week-2.csv", "standard-cut-raw.parquet", *OF)),
    Command("import of cards", ("import", "cards.csv"), (("export", "--cards", "cards.csv", *OF),)),
    Command(
        "calibrate --card",
        ("calibrate", "--machine", OTHER, "--card", "card.html"),
        (
            ("machine", "add", OTHER),
            ("import", "standard.csv", "--machine", OTHER),
        ),
    ),
    Command(
        "identify --page",
        ("identify", "air-moves.csv", "--machine", OTHER, "--page", "axis.html"),
        (("machine", "add", OTHER),),
    ),
    Command("scale", ("scale", "push.csv", *OF)),
    Command(
        "reconstruct --page",
        ("reconstruct", "push.csv", *OF, "--out", "load.csv", "--page", "load.html"),
    ),
    Command(
        "inspect",
        ("inspect", "part.toml", *OF, "--recording", "week.csv", "--cut", "3"),
    ),
    Command("refresh", ("refresh", *OF), (("import", "in/a.csv", *OF),)),
    Command("refresh --inbox", ("refresh", *OF, "--inbox", "in"), shared=PASSES),
    Command("schedule --out", ("schedule", *OF, "--inbox", "in", "--out", ".")),
    Command(
        "predict --csv --plot",
        ("predict", "job.toml", *OF, "--csv", "job.csv", "--plot", "job.html"),
        again=True,
    ),
    Command("predictions match", MATCH, PREDICTED),
    Command(
        "predictions score --plot",
        ("predictions", "score", *OF, "--plot", "score.html"),
        (*PREDICTED, MATCH, ("refresh", *OF)),
    ),
    Command("explain --machine", ("explain", "later.csv", *OF, "--out", "answer")),
    Command("mismatch confirm", ("mismatch", "confirm", "1"), (EXPLAINED,)),
    Command("mismatch reject", ("mismatch", "reject", "1"), (EXPLAINED,)),
    Command(
        "mismatch reopen", ("mismatch", "reopen", "1"), (EXPLAINED, ("mismatch", "confirm", "1"))
    ),
    Command("edge changed", CHANGED),
    Command("edge undo", ("edge", "undo", "1"), (CHANGED,)),
    Command("withdraw", WITHDRAW),
    Command(
        "withdraw --undo",
        ("withdraw", "3", *OF, "--undo"),
        (WITHDRAW,),
    ),
    Command("backup", ("backup", "monday.sqlite3")),
    Command("backup --replace", ("backup", "monday.sqlite3", "--replace"), (MONDAY,)),
    Command(
        "backup --keep --every",
        ("backup", "kept", "--keep", "3", "--every", "day"),
        (MONDAY, _with_dated_backups),
    ),
    Command("restore", ("restore", "monday.sqlite3"), (MONDAY, _without_a_database)),
    Command("restore --replace", ("restore", "monday.sqlite3", "--replace"), (MONDAY,)),
    Command("restore of an export", ("restore", "all", "--replace"), (("export", "all"),)),
    Command("export", ("export", "all")),
    Command("export --cards", ("export", "--cards", "cards.csv", *OF)),
    Command("export --coefficients", ("export", "--coefficients", "pairs.json", *OF)),
    Command("demo", ("demo", "--out", "demo-out"), seldom=True),
    Command(
        "standard new",
        ("standard", "new", "mine", "standard-cuts.csv", "--date", "2026-01-02"),
    ),
    Command(
        "standard program --out",
        ("standard", "program", "turning-aluminium", "--machine-file", "lathe.toml",
         "--dialect", "fanuc", "--out", "cuts.nc"),
    ),
    Command(
        "sweep --out",
        ("sweep", "--axis", "z", "--dialect", "fanuc", "--park", "x=150", "--machine-file",
         "machine.toml", "--out", "moves.nc"),
    ),
    Command("fleet refresh", ("fleet", "refresh"), (("import", "in/a.csv", *OF),)),
    Command("fleet learn", ("fleet", "learn")),
    Command("token add", ("token", "add", "panel")),
    Command("token revoke", ("token", "revoke", "panel"), (("token", "add", "panel"),)),
    Command(
        "backup --replace, large",
        ("backup", "monday.sqlite3", "--replace"),
        (MONDAY,),
        large=True,
        seldom=True,
    ),
    Command(
        "restore --replace, large",
        ("restore", "monday.sqlite3", "--replace"),
        (MONDAY,),
        large=True,
        seldom=True,
    ),
    Command(
        "refresh --inbox, large",
        ("refresh", *OF, "--inbox", "in"),
        large=True,
        seldom=True,
        shared=PASSES,
    ),
    Command("withdraw, large", WITHDRAW, large=True, seldom=True),
)  # fmt: skip
