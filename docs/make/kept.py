"""What commands printed and is kept here: proofs, and comparisons with other methods, as tables."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from autodb.proofs.catalogue import PROOFS
from autodb.proofs.runs.found import TextTable, passed_words
from autodb.proofs.runs.real.real_rows import PEER_HEADS
from benchmarks.anfis import ERRORS, PublishedErrors
from benchmarks.axis_peers.run import ORACLE, OURS, AxisErrors
from benchmarks.axis_peers.run import ROWS as AXIS_ROWS
from benchmarks.emps_peers import ROWS as LOAD_ROWS
from benchmarks.peers.real_peer_run import GROUPS, RUNS
from benchmarks.peers.run import FORWARD, METHODS
from benchmarks.peers.run import kept as kept_scores
from benchmarks.peers.table import tables as peer_tables
from benchmarks.vicomtech_peers import ROWS as FORCE_ROWS
from docs.make import pair_peers, peers, proofs

HERE = Path(__file__).parent
FROLS = HERE / "frols.jsonl"
PEERS = "--python PEERS/bin/python"


class NothingKept(Exception):  # noqa: N818 - says what happened
    """A page asks for what nothing is kept of."""


@dataclass(frozen=True)
class Kept:
    """What a command printed and is kept: its tables, the command, product and number of runs."""

    tables: Sequence[TextTable]
    command: str
    product: str
    runs: int

    @property
    def short(self) -> str:
        """The command without its options: what is to be proven, or the module."""
        return " ".join(self.command.split()[:3])


@cache
def kept(name: str) -> Kept:
    """Return the tables kept of a proof, or of a comparison, by name; raises NothingKept."""
    if name in {one.name for one in PROOFS}:
        found = proofs.kept(name)
        first, last = found.seeds
        command = f"autodb prove {name}"
        return Kept(found.tables(), command, found.origin.product, last - first + 1)
    if name not in COMPARISONS:
        raise NothingKept(f"nothing is kept of '{name}'")
    return COMPARISONS[name]()


def _concealed() -> Kept:
    return _scores(peers.KEPT, METHODS, "")


def _forward() -> Kept:
    return _scores(FROLS, FORWARD, f" --methods {' '.join(FORWARD)}")


def _scores(path: Path, methods: Sequence[str], asked: str) -> Kept:
    scores = kept_scores(path)
    command = f"python -m benchmarks.peers.run {PEERS} --out {path.name}{asked}"
    seeds = {one.seed for one in scores}
    return Kept(peer_tables(scores, methods), command, scores[0].origin.product, len(seeds))


def _boosted() -> Kept:
    curve = kept("pair-curve")
    command = "python -m benchmarks.pair_peers pair-curve-proof/pair-curve.jsonl pair-peers.json"
    return Kept([pair_peers.table()], command, curve.product, curve.runs)


def _axes() -> Kept:
    rows = AXIS_ROWS.validate_json((HERE / "axis-peers.json").read_bytes())
    command = f"python -m benchmarks.axis_peers.run {PEERS} --out axis-peers.json"
    return Kept([axis_table(rows)], command, rows[0].product, rows[0].axes)


def axis_table(rows: Sequence[AxisErrors]) -> TextTable:
    """Return errors of ways to identify an axis; autodb's must not be above the best other's."""
    best = min(row.median for row in rows if row.method not in (OURS, ORACLE))
    heads = ("way", "version", ">median error", ">90 % below", ">s", ">must be ≤", "")
    return TextTable(
        "Currents of steady motion, error over Coulomb friction",
        heads,
        tuple(
            (
                row.method,
                row.version,
                _percent(row.median),
                _percent(row.tenth),
                f"{row.seconds:.1f}",
                _percent(best) if row.method == OURS else "",
                passed_words(row.median <= best) if row.method == OURS else "",
            )
            for row in rows
        ),
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2f} %"


def sugeno_errors() -> PublishedErrors:
    """Return what is kept of Sugeno systems on published examples."""
    return ERRORS.validate_json((HERE / "anfis-peers.json").read_bytes())


def sugeno_table() -> TextTable:
    """Return errors and times of libraries on Jang's series."""
    rows = sugeno_errors().series
    return TextTable(
        "Mackey-Glass, 16 rules, RMSE",
        ("library", ">train", ">check", ">s"),
        tuple((r.name, f"{r.train:.6f}", f"{r.check:.6f}", f"{r.seconds:.1f}") for r in rows),
    )


def _sugeno() -> Kept:
    command = f"python -m benchmarks.anfis --series FOLDER {PEERS} --out anfis-peers.json"
    return Kept([sugeno_table()], command, "", 1)


def _loads() -> Kept:
    rows = LOAD_ROWS.validate_json((HERE / "emps-peers.json").read_bytes())
    command = "python -m benchmarks.emps_peers DATA_EMPS.mat DATA_EMPS_PULSES.mat emps-peers.json"
    table = TextTable(
        "Pulses of EMPS up to 10 Hz",
        ("way", "version", ">RMSE"),
        tuple((r.method, r.version, f"{r.rmse_N:.2f} N") for r in rows),
    )
    return Kept([table], command, "", 1)


def _feed_forces() -> Kept:
    rows = FORCE_ROWS.validate_json((HERE / "vicomtech-peers.json").read_bytes())
    command = (
        "python -m benchmarks.vicomtech_peers Dataset_Machine_tool_wear.csv vicomtech-peers.json"
    )
    table = TextTable(
        "Feed force on tools left out",
        ("way", "inputs", "version", ">RMSE", ">less autodb's, 95 %"),
        tuple(
            (
                row.method,
                row.inputs,
                row.version,
                f"{row.rmse_N:.1f} N",
                f"{row.less_low_N:+.1f} to {row.less_high_N:+.1f} N",
            )
            for row in rows
        ),
    )
    return Kept([table], command, "", rows[0].tools)


def _named_on_real_axes() -> Kept:
    """Names of other methods have no figure of ours, so that no product stands behind them."""
    groups = GROUPS.validate_json((HERE / "real-peers.json").read_bytes())
    module = "python -m benchmarks.peers.real_peer_run"
    command = f"{module} {PEERS} --out real-peers.jsonl --table real-peers.json"
    table = TextTable("On real axes", PEER_HEADS, tuple(one.cells() for one in groups))
    return Kept([table], command, "", RUNS)


COMPARISONS: dict[str, Callable[[], Kept]] = {
    "peers": _concealed,
    "frols": _forward,
    "real-peers": _named_on_real_axes,
    "pair-peers": _boosted,
    "axis-peers": _axes,
    "anfis-peers": _sugeno,
    "emps-peers": _loads,
    "vicomtech-peers": _feed_forces,
}
