"""Raw recordings of virtual cuts, clean and disturbed, at six conditions in turn."""

from collections.abc import Callable
from pathlib import Path

from autodb.errors import SetAside
from autodb.proofs.machines.lathe.disturbed import CutDisturbance, Disturbed, disturbed_cut
from autodb.proofs.machines.lathe.jobs import cut_at
from autodb.proofs.machines.lathe.process import TrueCut
from autodb.proofs.machines.sample import SAMPLE_LATHE, SAMPLE_PAIR, write_parquet
from autodb.records.tables import Recording
from autodb.sensing.ranges.recorded import raw

CONDITIONS = (  # depth mm, feed mm/rev, speed rpm, machined diameter mm
    (1.0, 0.10, 2400.0, 48.0),
    (1.5, 0.20, 1000.0, 68.0),
    (2.0, 0.20, 1500.0, 62.0),
    (2.0, 0.30, 800.0, 66.0),
    (2.5, 0.10, 2100.0, 50.0),
    (2.0, 0.40, 1800.0, 40.0),
)
NOTHING = CutDisturbance()


def condition(seed: int, duration_s: float = 10.0) -> TrueCut:
    """Return the seed's cut."""
    return cut_at(CONDITIONS[seed % len(CONDITIONS)], duration_s=duration_s)


def made(seed: int, what: CutDisturbance = NOTHING, duration_s: float = 10.0) -> Disturbed:
    """Return the seed's cut as it was recorded."""
    return disturbed_cut(SAMPLE_LATHE, SAMPLE_PAIR, condition(seed, duration_s), seed, what)


def read(cut: Disturbed, only: Callable[[str], bool] = lambda _: True) -> raw.RawCut | str:
    """Return the cut of a recording, of channels that ``only`` keeps, or why it is excluded."""
    channels = {name: values for name, values in cut.channels.items() if only(name)}
    try:
        return raw.cut_of_recording(Recording(path=Path("cut.parquet"), channels=channels))
    except SetAside as error:
        return str(error)


def row_of(cut: raw.RawCut | str) -> dict[str, float]:
    """Return the row of a cut that is not excluded."""
    assert isinstance(cut, raw.RawCut), cut
    return {name: float(values[0]) for name, values in cut.table.channels.items()}


def write_raw(
    path: Path, seed: int, what: CutDisturbance = NOTHING, duration_s: float = 5.0
) -> Path:
    """Write the seed's recording with its side file; return the path."""
    cut = condition(seed, duration_s)
    write_parquet(path, made(seed, what, duration_s).channels)
    path.with_suffix(".toml").write_text(
        f'[recording]\nwork = "{cut.material}"\n[tool]\nname = "{SAMPLE_PAIR.tool}"\n'
        f'[cut]\noperation = "{cut.operation}"\ndepth_mm = {cut.depth_mm}\n'
        f"feed_mm_rev = {cut.feed_mm}\nspeed_rpm = {cut.spindle_rpm:.1f}\n"
        f"work_diameter_mm = {cut.diameter_mm}\n",
        encoding="utf-8",
    )
    return path
