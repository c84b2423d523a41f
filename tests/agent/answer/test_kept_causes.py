"""Causes of an explanation are kept as open mismatches of their recording."""

from pathlib import Path

from autodb.agent.answer.explaining import keep_mismatches
from autodb.explain.answer import (
    Cause,
    ChannelAnswer,
    Explained,
    Explanation,
    FitQuality,
    IntervalValue,
    Where,
)
from autodb.store import models, open_store
from tests.conftest import Cli

FIT = FitQuality(
    rms_before=1.0, rms_after=0.5, heldout_before=1.0, heldout_after=0.5, noise_floor=0.5
)


def _unnamed(size: float, *may_be: str) -> Cause:
    value = IntervalValue(value=size, low=0.5 * size, high=1.5 * size, unit="A")
    return Cause(
        term="unknown", kind="missing", confidence=0.7, statement=f"Up to {size} A.",
        parameters={"size": value}, alternatives=may_be,
    )  # fmt: skip


def test_of_several_causes_without_a_name_in_a_channel_the_largest_is_kept(cli: Cli) -> None:
    assert cli("init").code == 0
    assert cli("machine", "add", "mill").code == 0
    causes = _unnamed(6.0, "lag", "cogging"), _unnamed(4.3, "spring", "lag")
    answer = ChannelAnswer(unit="A", mismatch=True, where=Where(), missing=causes, fit=FIT)
    explained = Explained(Explanation(recording="r.csv", channels={"x.current": answer}), {})
    store = open_store("sqlite:///autodb.sqlite3")
    with store.writing() as session:
        recording = models.StoredRecording(
            machine_id=1, sha256="r", path=str(Path("r.csv")), kind="series", rows=10, units={},
            side={},
        )  # fmt: skip
        session.add(recording)
        session.flush()
        kept = keep_mismatches(session, recording.id, explained)
        again = keep_mismatches(session, recording.id, explained)
        (row,) = session.query(models.Mismatch).all()
        assert kept == again
        assert row.parameters["size"]["value"] == 6.0
        assert row.alternatives == ["lag", "cogging"]
    store.close()
