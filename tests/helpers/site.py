"""A machine that has learnt something, for what is tried on the pages."""

from pathlib import Path

import pandas as pd

from autodb.agent.answer.explaining import explain_with_machine
from autodb.agent.rows.machines import add_machine
from autodb.assets import kit
from autodb.cli.start import demo
from autodb.files.machine import LATHE
from autodb.store import create_store, models, open_store

LIMITS_N = {"x": 600.0, "z": 900.0}
STRANGE = 'a/b <script>alert("x")</script> & c'
"""Name of a machine that a page could be broken by."""


def filled(path: Path) -> str:
    """Make the sample machine's database, with what a later week's edges lack, limits and one
    more machine; return its URL.
    """
    url = f"sqlite:///{path}"
    create_store(url)
    store = open_store(url)
    source = kit("sample_jobs") / demo.JOB / "recordings"
    demo.learn_from_samples(store, source, progress=lambda _: None)
    later = path.with_name("later-week.csv")
    week = pd.read_csv(source / demo.WORN)
    week.assign(t=week["t"] + 604_800.0).to_csv(later, index=False)
    explain_with_machine(store, demo.MACHINE, later)
    with store.writing(demo.MACHINE) as session:
        for axis in session.query(models.Axis).all():
            axis.limit_force_N = LIMITS_N.get(axis.name)
            axis.limit_torque_N_m = 30.0 if axis.name == "spindle" else None
    add_machine(store, STRANGE, LATHE)
    store.close()
    return url
