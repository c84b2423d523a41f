"""What `explain` answers to a table of cuts: two files on the disk, the command, its answer."""

import json
import time
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.tables.table_case import TabledCase
from autodb.proofs.cases.tables.table_cases import tabled_case
from autodb.proofs.runs.real.real_answers import RealAnswer, read_answer
from autodb.proofs.runs.stamps.stamp_answers import ran_command


def explained_table(case: TabledCase) -> dict[str, RealAnswer]:
    """Write the table and its simulation, ask the command, return an answer for each component."""
    with TemporaryDirectory(prefix="autodb-table-") as name:
        folder = Path(name)
        case.recording().to_csv(folder / "recording.csv", index=False)
        case.simulation().to_csv(folder / "simulation.csv", index=False)
        begun = time.perf_counter()
        said = ran_command(
            folder, "explain", f"{folder}/recording.csv", "--simulation",
            f"{folder}/simulation.csv", "--includes", ",".join(case.includes),
            "--out", f"{folder}/answer",
        )  # fmt: skip
        seconds = time.perf_counter() - begun
        path = folder / "answer" / "explanation.json"
        held = json.loads(path.read_text("utf-8")) if path.exists() else {}
    return {one.channel: read_answer(held, one.channel, said, seconds) for one in case.cases}


@cache
def answered_null(spec: RealSpec) -> dict[str, RealAnswer]:
    """Return the answers to a table without an effect; each is asked once."""
    return explained_table(tabled_case(spec))
