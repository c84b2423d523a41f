"""Measured forces teach: tables and recordings with force channels, without any current."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.agent.answer.budgets import budget_of_force
from autodb.agent.rows.posteriors import as_posterior
from autodb.agent.sense.measured import MEASURED
from autodb.agent.sense.sensed import as_observed
from autodb.pairs.modelled import Modelled
from autodb.pairs.updating import reading_errors
from autodb.store import models, open_store
from tests.conftest import Cli, shared
from tests.helpers.force_tables import HeldOut, drawn_cuts, held_out, joined, power_forces, write_table

DATA = Path(__file__).parents[2] / "data"
URL = "sqlite:///autodb.sqlite3"
NAMED = '[recording]\nwork = "metal"\n[tool]\nname = "insert"\nkind = "turning_insert"\n'


def _began(cli: Cli) -> None:
    cli("init").succeeded()
    cli("machine", "add", "lathe").succeeded()


def _learnt(cli: Cli, *files: Path) -> str:
    """Import and refresh; return what the refresh said."""
    for file in files:
        cli("import", file, "--machine", "lathe").succeeded()
    return cli("refresh", "--machine", "lathe").succeeded().out


def _predicted(cli: Cli, column: int, **cut: float) -> tuple[float, float, float]:
    import json

    asked = [f"--{name.replace('_', '-')}={value}" for name, value in cut.items()]
    names = ("lookup", "--machine", "lathe", "--json")
    answer = json.loads(cli(*names, *asked).succeeded().out)
    one = answer["cut"][f"force_{'xyz'[column]}_N"]
    return one["value"], one["low"], one["high"]
