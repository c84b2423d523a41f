"""Programs that are sent with a job, predicted as the command does."""

import json
from pathlib import Path
from typing import Any

import pytest

from autodb.errors import UnusableInput
from autodb.files.job import read_job
from autodb.proofs.runs.keeping.flips import read_rows
from autodb.web.client import Client
from autodb.web.http.settings import Settings
from tests.conftest import Cli
from tests.helpers.asked import detail
from tests.helpers.sending import PREDICT, serving
from tests.helpers.serving import served


def test_a_program_is_predicted_as_the_command_does(
    cli: Cli, sample_jobs: Path, tmp_path: Path
) -> None:
    """Also where its file is called otherwise; and what is wrong with one is said with its line."""
    file = sample_jobs / "nc_profile" / "job.toml"
    cli("init")
    cli("machine", "add", "lathe-1")
    alone = json.loads(cli("predict", file, "--machine", "lathe-1", "--json").out)
    url = f"sqlite:///{Path('autodb.sqlite3').resolve()}"
    before = read_rows(Path("autodb.sqlite3"))
    job = read_job(file)
    assert job.program is not None
    with served(Settings(url)) as at, Client(at) as client:
        found = client.predict_program("lathe-1", job)
        (tmp_path / "broken.nc").write_text("G0 X10\nG77 Z3\n")
        program = job.program.model_copy(update={"file": str(tmp_path / "broken.nc")})
        with pytest.raises(UnusableInput, match=r"^broken\.nc: line 2: .*G77"):
            client.predict_program("lathe-1", job.model_copy(update={"program": program}))
    said = json.loads(json.dumps(found, default=_plain))
    for name in ("cuts", "behind", "notes", "exceeds"):
        assert said[name] == alone[name], name
    assert said["job"]["program"] == alone["job"]["program"] | {"file": "part.nc"}
    assert read_rows(Path("autodb.sqlite3")) == before


MILLED = b"G21 G90 G17\nT3 M6\nS1000 M3\nG0 X-10 Y10 Z5\nG1 Z-2 F200\nX60\nM30\n"
JOB = """name = "plate"
material = "C45"
tool = "T3"
[program]
file = "another.nc"
block_mm = [0, 50, 0, 50, -10, 0]
[program.tools.3]
kind = "end_mill"
diameter_mm = 10
teeth = 4
"""


def test_a_job_is_sent_in_json_with_typed_numbers_or_as_its_file(url: str) -> None:
    tool = {"kind": "end_mill", "diameter_mm": "10,0", "teeth": "4"}
    block = ["0", "50", "0", "50", "-10,0", "0"]
    said = {"name": "plate", "material": "C45", "tool": "T3"}
    typed = json.dumps(said | {"program": {"block_mm": block, "tools": {"3": tool}}})
    with serving(url) as client:
        of_json, of_file, of_wrong = (
            client.post(
                PREDICT,
                files={"job": job, "program": ("plate.nc", MILLED)},
            )
            for job in (
                (None, typed.encode()),
                ("job.toml", JOB.encode()),
                ("job.toml", JOB.replace("block_mm", "blok_mm").encode()),
            )
        )
    assert of_json.status_code == of_file.status_code == 200, (of_json.text, of_file.text)
    assert of_json.json()["cuts"] == of_file.json()["cuts"] != []
    assert of_file.json()["job"]["program"]["file"] == "plate.nc"
    assert of_wrong.status_code == 422
    assert detail(of_wrong).startswith("job.toml: program.blok_mm: unknown key"), detail(of_wrong)


def _plain(value: Any) -> Any:
    return value.model_dump(mode="json") if hasattr(value, "model_dump") else vars(value)


@pytest.mark.parametrize(
    ("files", "line"),
    [
        ({"program": ("a.nc", b"G0")}, "job: missing; send both as parts"),
        ({"job": (None, b"{"), "program": ("a.nc", b"G0")}, "job: is not JSON"),
        ({"job": (None, b"[" * 9999), "program": ("a.nc", b"G0")}, "job: is not JSON"),
        ({"job": (None, b"3"), "program": ("a.nc", b"G0")}, "job: "),
        ({"job": (None, b'{"name": 3}'), "program": ("a.nc", b"G0")}, "job: name: "),
        (
            {
                "job": (None, b'{"name": "a", "material": "b", "tool": "c", "program": {}}'),
                "program": ("a.nc", b"G0"),
            },
            "job: program: give one of stock_diameter_mm",
        ),
        (
            {
                "job": (None, b'{"name": "a", "material": "", "tool": "c", "program": {}}'),
                "program": ("a.nc", b"G0"),
            },
            "job: material: is empty",
        ),
        (
            {
                "job": (
                    None,
                    b'{"name": "a", "material": "b", "tool": "c", "cut": [{"depth_mm": 1, '
                    b'"diameter_mm": 9, "feed_mm_rev": 0.1, "speed_rpm": 100}]}',
                ),
                "program": ("a.nc", b"G0"),
            },
            "job: program: missing",
        ),
    ],
)
def test_a_job_that_cannot_be_is_refused(url: str, files: Any, line: str) -> None:
    with serving(url) as client:
        got = client.post(PREDICT, files=files)
    assert (got.status_code, line in detail(got)) == (422, True), got.text
