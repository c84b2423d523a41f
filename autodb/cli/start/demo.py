"""The whole job on a sample machine: currents, forces, parameters, a prediction, a named cause."""

import shutil
import sys
from collections.abc import Callable
from pathlib import Path

from autodb.agent.answer.explaining import explain_with_machine
from autodb.agent.answer.predicting import Predicted, predict_job
from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.agent.sense.identifying import identify_on_machine
from autodb.assets import kit
from autodb.cli._reader import in_english
from autodb.errors import UnusableInput
from autodb.explain.answer import Explained
from autodb.files.job import read_job
from autodb.files.machine import LATHE
from autodb.files.targets import hidden, replace_by
from autodb.records.source import read
from autodb.records.tables import Recording
from autodb.reports.explanation import explanation_fragment, statement_words
from autodb.reports.explanation_files import write_answer
from autodb.reports.machine_page import machine_page
from autodb.reports.page import render_page
from autodb.reports.written import write_page
from autodb.store import Store, create_store, open_store
from autodb.wording import amount_words, listed, localized, msgid, phrase, shop_amount, significant
from autodb.wording.kept import said_again

JOB = "stepped_shaft"
MACHINE = "lathe-1"
LEARNT = ("standard-cuts.csv", "standard-cut-raw.parquet", "air-moves.csv", "shop-week-1.csv")
WORN = "shop-week-2.csv"
MARK = ".autodb-demo"
DATABASE, REPORT, JOB_FILE = "autodb.sqlite3", "report.html", "job.toml"


Line = tuple[str, str]
"""What a line of the summary is of, and what it says."""
AXIS, FORCES, PREDICTED, LEFT_OUT = (
    msgid("axis"), msgid("forces"), msgid("predicted"), msgid("left out"),
)  # fmt: skip
USABLE = msgid("{axis} → force.{component}, RMSE {rmse}, R² {r_squared} on held-out cuts (usable)")
NOT_USABLE = msgid(
    "{axis} → force.{component}, RMSE {rmse}, R² {r_squared} on held-out cuts (not usable)"
)


def run_demo(out: Path, *, progress: Callable[[str], None]) -> list[Line]:
    """Run the main job into folder ``out`` and return the lines of its summary.

    An earlier demo in ``out`` is replaced once this one is whole. Raises UnusableInput when ``out``
    holds anything else.
    """
    _may_be_replaced(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    with hidden(out, progress) as part:
        _may_be_replaced(out)  # another may have written it meanwhile
        part.mkdir()
        (part / MARK).touch()
        prediction, lines = _played(part, progress=progress)
        replace_by(part, out)
    command = "autodb" if shutil.which("autodb") else sys.argv[0]
    url = f"sqlite:///{out / DATABASE}"
    trace = f"{command} trace prediction {prediction} --db {url}"
    files = [
        (msgid("job"), str(out / JOB_FILE)), (msgid("trace"), trace),
        (msgid("report"), str(out / REPORT)),
    ]  # fmt: skip
    return [*lines, *files]


def _played(folder: Path, *, progress: Callable[[str], None]) -> tuple[int, list[Line]]:
    """Run the job in a new folder; return the number of its prediction, and what it found."""
    source = kit("sample_jobs") / JOB / "recordings"
    url = f"sqlite:///{folder / DATABASE}"
    create_store(url)
    store = open_store(url)
    try:
        with in_english():  # what is found is kept
            lines = learn_from_samples(store, source, progress=progress)
            progress("predicting the stepped shaft")
            prediction = predict_job(store, MACHINE, read_job(kit("sample_jobs") / JOB / JOB_FILE))
            progress("explaining the second week")
            explained = explain_with_machine(store, MACHINE, source / WORN).explained
        write_answer(explained, folder / "shop-week-2-explained")
        progress("writing the report")
        page = machine_page(store, MACHINE, prediction.prediction_id)
        report = render_page(page, explanation_fragment(explained))
        write_page(folder / REPORT, report)
        shutil.copyfile(kit("sample_jobs") / JOB / JOB_FILE, folder / JOB_FILE)
    finally:
        store.close()
    return prediction.prediction_id, lines + _predicted(prediction) + _explained(explained)


def learn_from_samples(
    store: Store, source: Path, *, progress: Callable[[str], None]
) -> list[Line]:
    """Import the sample recordings and learn from them: calibration, drive model, parameters."""
    add_machine(store, MACHINE, LATHE)
    for name in LEARNT:
        progress(f"importing {name}")
        import_file(store, source / name, machine=MACHINE)
        if name == "air-moves.csv":
            moves = read(source / name)
            assert isinstance(moves, Recording)
            identify_on_machine(store, MACHINE, source / name, moves)
    calibrated = calibrate_machine(store, MACHINE, progress=progress)
    refreshed = refresh(store, MACHINE, progress=progress)
    lines = list[Line]()
    for c in calibrated.calibrations:
        rmse = amount_words(float(significant(c.scores.rmse)), c.unit)
        said = phrase(
            USABLE if c.offered else NOT_USABLE,
            axis=c.axis, component=c.component, rmse=rmse,
            r_squared=localized(f"{c.scores.r_squared:.2f}")
        )  # fmt: skip
        lines.append((AXIS, said))
    return [*lines, (FORCES, refreshed.forces_words)]


def _may_be_replaced(out: Path) -> None:
    """Raise UnusableInput where ``out`` is anything but an earlier demo, or an empty folder."""
    if not out.exists():
        return
    if not out.is_dir():
        raise UnusableInput(phrase("{out}: is a file; --out needs a folder", out=out))
    if any(out.iterdir()) and not (out / MARK).exists():
        raise UnusableInput(
            phrase("{out}: holds other files; give a new folder with --out", out=out)
        )


def _predicted(prediction: Predicted) -> list[Line]:
    scale, unit = shop_amount(1.0, "N")
    lines = list[Line]()
    for cut in prediction.cuts:
        force = cut.force_y_N
        three = (force.value, force.low, force.high)
        value, low, high = (localized(f"{scale * one:.0f}") for one in three)
        said = phrase(
            "{cut}: cutting force {value} {unit} ({low} to {high})",
            cut=cut.name, value=value, unit=unit, low=low, high=high
        )  # fmt: skip
        lines.append((PREDICTED, said))
    return lines


def _explained(explained: Explained) -> list[Line]:
    return [
        (LEFT_OUT, listed([f"{channel}: {cause.term}", _statement(cause.statement)], ": "))
        for channel, answer in explained.explanation.channels.items()
        for cause in answer.missing
    ]


def _statement(text: str) -> str:
    return listed(map(said_again, statement_words(text)), " ")
