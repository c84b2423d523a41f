"""The built wheel works without the checkout: each kit that it brings is used, and a page is drawn.

The whole demo from a wheel is `make wheel-demo`; in the checkout tests/cli/test_demo.py runs it.
"""

import os
import subprocess
import sys
from pathlib import Path

from hatchling.builders.wheel import WheelBuilder

from tests.conftest import ROOT
from tests.helpers.released import VERSIONS, unpacked

JOB = """
import sys
from pathlib import Path

checkout, unpacked = (Path(p).resolve() for p in sys.argv[1:])
sys.path = [p for p in sys.path if not (Path(p) / "pyproject.toml").exists()]
assert str(checkout) not in sys.path

import autodb
from autodb.assets import kit
from autodb.cli import run

for found in (Path(autodb.__file__), kit("sample_jobs"), kit("calibration"), kit("schema")):
    assert found.resolve().is_relative_to(unpacked), found
for asked in (
    ["init"],
    ["machine", "add", "lathe-1"],
    ["standard", "show", "turning-aluminium"],
    ["predict", str(kit("sample_jobs") / "stepped_shaft" / "job.toml"), "--plot", "job.html"],
    ["lookup", "--material", "C45", "--tool", "CNMG 120408", "--diameter", "50", "--depth", "2",
     "--feed", "0.25", "--speed", "220"],
    ["serve", "--help"],
    *(["init", "--db", f"sqlite:///{path}"] for path in sorted(Path().glob("0.*.sqlite3"))),
    ["doctor"],
    ["--version"],
):
    if code := run(asked):
        sys.exit(code)
"""


def test_the_wheel_predicts_a_job_away_from_the_checkout(tmp_path: Path) -> None:
    installed, elsewhere = tmp_path / "installed", tmp_path / "elsewhere"
    elsewhere.mkdir()
    earlier = [unpacked(name, elsewhere / f"{name}.sqlite3") for name in VERSIONS]
    wheel = next(WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"]))
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index",
         "--no-compile", "--target", str(installed), wheel],
        check=True,
    )  # fmt: skip
    assert (installed / "bin" / "autodb").exists()
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", JOB, str(ROOT), str(installed)],
        capture_output=True, text=True, cwd=elsewhere, check=False, env=_environment(installed),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "rough Ø56" in done.stdout
    assert "predicted from conventional values of C45" in done.stdout
    assert earlier
    for schema in earlier:
        assert f"upgraded from schema {schema} to" in done.stdout
    assert "Usage: autodb serve" in done.stdout
    assert "FAILED" not in done.stdout
    assert (elsewhere / "job.html").exists()


def _environment(unpacked: Path) -> dict[str, str]:
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "AUTODB_DB")}
    return {**kept, "PYTHONPATH": str(unpacked)}
