"""What a command loads: what it does not run, it does not import."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.files import write

PAIR = ("--material", "steel bar", "--tool", "carbide insert")
ONE_CUT = ("--diameter", "50", "--depth", "1.5", "--feed", "0.2", "--speed", "220")
HEAVY = {"scipy", "pandas", "pyarrow", "plotly", "babel"}  # babel reads what is said in German
OTHER_DATABASE = "sqlalchemy.dialects.postgresql"


MAPPERS = "mappers-set-up"
"""Stands for a library that takes time: what asks tables alone needs none."""


def _loaded(*arguments: str) -> tuple[set[str], int]:
    """Return the libraries that a command loads, and how many modules of this package."""
    code = (
        f"import sys; from autodb.cli import run; assert run({list(arguments)}) == 0; "
        "models = sys.modules.get('autodb.store.models'); "
        "mappers = models.Base.registry.mappers if models else (); "
        f"more = [{MAPPERS!r}] if any(m.configured for m in mappers) else []; "
        "print(*sys.modules, *more, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names = done.stderr.splitlines()[-1].split()
    return set(names), sum(name.startswith("autodb.") for name in names)


def test_what_a_command_has_made_is_not_searched_for_garbage_as_python_ends() -> None:
    code = (
        "import atexit, gc, sys; atexit.register(lambda: print(gc.get_freeze_count())); "
        "from autodb.cli import main; sys.argv[1:] = ['--version']; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout.splitlines()[-1]) > 10_000


@pytest.mark.usefixtures("one_law", "standard_learnt")
def test_an_answer_from_what_is_learnt_loads_nothing_that_learns(sample_jobs: Path) -> None:
    job = str(sample_jobs / "stepped_shaft" / "job.toml")
    for asked in (("lookup", *PAIR, *ONE_CUT), ("predict", job)):
        names, own = _loaded(*asked)
        assert names & (HEAVY | {OTHER_DATABASE}) == set()
        assert own <= 100
        assert (MAPPERS in names) == (asked[0] == "predict")  # which writes its answer as rows


def test_an_explanation_of_an_axis_loads_no_other_kind_of_recording(tmp_path: Path) -> None:
    time_s = 0.004 * np.arange(2000)
    velocity = 40.0 * np.sin(2.5 * time_s)
    place = np.cumsum(velocity) * 0.004
    simulated = 1.2 * np.tanh(velocity) + 0.004 * velocity
    noise = 0.03 * np.random.default_rng(41).normal(size=time_s.size)
    axis = {"t": time_s, "x.position": place, "x.velocity": velocity}
    measured = simulated + 0.3 * np.sin(0.8 * place) + noise
    for name, current in (("measured", measured), ("simulated", simulated)):
        write(tmp_path / f"{name}.csv", axis | {"x.current": current})
    files = [str(tmp_path / name) for name in ("measured.csv", "simulated.csv")]
    names, own = _loaded(
        "explain", files[0], "--simulation", files[1], "--out", str(tmp_path / "out")
    )
    for room in ("agent", "store", "pairs", "forward", "explain.cuts", "explain.waves"):
        assert f"autodb.{room}" not in names
    assert own <= 160
