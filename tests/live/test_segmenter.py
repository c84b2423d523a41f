"""Cuts out of values that come in: told apart, whole, and the same whatever the line does."""

import errno
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.live import journal as journals
from autodb.live.agentfile import AgentFile, Condition, StatedItem, WorkSection, read_agentfile
from autodb.live.batch import Batch, Value
from autodb.live.journal import Journal
from autodb.live.recorder import side_of
from autodb.live.segmenter import LiveCut, Segmenter

RATE = 50.0
BEGIN_S = 1_790_000_000.0
ON = [(2.0, 5.0), (5.1, 6.0), (9.0, 9.2), (12.0, 19.0)]
"""When it feeds, s: a pause of 0.1 s, a cut that is too short, one that is longer than allowed."""
PLAN = AgentFile.model_validate(
    {
        "machine": "m",
        "rate_hz": RATE,
        "source": {"protocol": "opcua", "url": "opc.tcp://h"},
        "channels": {"x.current": "i", "x.position": {"item": "p", "scale": 2.0}},
        "cut": {
            "while": [{"item": "feed", "above": 0.0}, {"item": "mode", "is": "auto"}],
            "before_s": 1.0,
            "after_s": 0.5,
            "pause_s": 0.3,
            "least_s": 0.5,
            "longest_s": 4.0,
            "depth_mm": {"item": "depth"},
        },
    }
)
Timed = tuple[float, str, Value]


def _values(seconds: float = 22.0) -> list[Timed]:
    """Return what a machine says, by instants."""
    said: list[Timed] = [(0.0, "mode", "AUTO"), (0.0, "feed", 0.0), (0.0, "depth", 1.0)]
    said += [(begin, "feed", 500.0) for begin, _ in ON]
    said += [(end, "feed", 0.0) for _, end in ON]
    said.append((11.0, "depth", 3.0))
    rng = np.random.default_rng(1)
    for k in range(round(seconds * RATE)):
        said.append((k / RATE, "i", float(rng.standard_normal())))
        if k % 10 == 0:
            said.append((k / RATE, "p", float(k // 10)))  # said when it changes
    return sorted(((BEGIN_S + at, item, value) for at, item, value in said), key=lambda one: one[0])


def _batch(said: Sequence[Timed], *, gap: bool = False) -> Batch:
    values: dict[str, tuple[list[float], list[Value]]] = {}
    for at, item, value in said:
        instants, heard = values.setdefault(item, ([], []))
        instants.append(at)
        heard.append(value)
    upto = max((at for at, _, _ in said), default=BEGIN_S)
    return Batch(values, upto, {"at": upto}, gap=gap)


def _cuts(batches: Sequence[Batch]) -> list[LiveCut]:
    segmenter = Segmenter(PLAN)
    return [cut for batch in batches for cut in segmenter.take(batch)]


def _alike(ours: Sequence[LiveCut], theirs: Sequence[LiveCut]) -> None:
    assert [(one.begin_s, one.end_s) for one in ours] == [(o.begin_s, o.end_s) for o in theirs]
    for one, other in zip(ours, theirs, strict=True):
        assert one.start_s == other.start_s
        assert one.said == other.said
        for name, column in one.columns.items():
            assert column.tolist() == other.columns[name].tolist()


WHOLE = _cuts([_batch(_values())])


def test_cuts_are_told_apart_joined_left_out_and_parted() -> None:
    spans = [(cut.begin_s - BEGIN_S, cut.end_s - BEGIN_S) for cut in WHOLE]
    assert_allclose(spans, [(2.0, 6.0), (12.0, 16.0), (16.0, 19.0)])
    assert [cut.said["cut.depth_mm"] for cut in WHOLE] == [1.0, 3.0, 3.0]
    first, second, third = WHOLE
    assert first.start_s == BEGIN_S + 1.0  # a second before it
    assert_allclose(first.t[-1], 5.5)  # and half a second after
    assert_allclose([second.start_s + second.t[-1] - BEGIN_S, third.start_s - BEGIN_S], [16, 15])
    assert_allclose(np.diff(first.t), 1.0 / RATE)


def test_rows_hold_what_was_said_last() -> None:
    said = _values()
    currents = [value for at, item, value in said if item == "i" and at >= BEGIN_S + 1.0]
    (first, *_) = WHOLE
    assert first.columns["x.current"].tolist() == currents[: len(first.t)]
    places = np.array([(at, float(value)) for at, item, value in said if item == "p"])  # type: ignore[arg-type]
    now = first.start_s + first.t
    held = places[np.searchsorted(places[:, 0], now + 1e-6, side="right") - 1, 1]
    assert first.columns["x.position"].tolist() == held.tolist()  # scaled by the side file


@pytest.mark.parametrize("seed", range(5))
def test_pieces_and_items_that_lag_change_nothing(seed: int) -> None:
    """Items come up to 0.4 s apart, in pieces of any length."""
    rng = np.random.default_rng([seed, 130])
    lag = {item: float(rng.uniform(0.0, 0.4)) for item in PLAN.items()}
    arriving = sorted(_values(), key=lambda one: one[0] + lag[one[1]])
    _alike(_cuts(list(_pieces(arriving, rng))), WHOLE)


def _pieces(said: Sequence[Timed], rng: np.random.Generator) -> Iterator[Batch]:
    place = 0
    while place < len(said):
        count = int(rng.integers(1, 40))
        yield _batch(said[place : place + count])
        place += count


@pytest.mark.parametrize("seed", range(12))
def test_killed_and_read_again_each_cut_is_there_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """Before or after it was written, its mark kept, files forgotten: the same cuts."""
    monkeypatch.setattr(journals, "FILE_BYTES", 4_000)
    rng = np.random.default_rng([seed, 131])
    pieces = list(_pieces(_values(), rng))
    written: dict[float, LiveCut] = {}
    place = 0
    while place < len(pieces):
        journal = Journal(tmp_path / "journal")
        said = journal.read()
        assert place == 0 or said.position == pieces[place - 1].position
        segmenter = Segmenter(PLAN, done_s=-np.inf if said.done_s is None else said.done_s)

        def write(cuts: list[LiveCut], made: Segmenter, kept: Journal, *, killed: bool) -> None:
            for cut in cuts:
                if cut.start_s in written:
                    _alike([cut], [written[cut.start_s]])
                written[cut.start_s] = cut
                if not killed:
                    kept.done(cut.end_s, made.latest)

        for batch in said.replayed():
            write(segmenter.take(batch), segmenter, journal, killed=False)
        lives = int(rng.integers(1, 12))
        for number in range(lives):
            if place == len(pieces):
                break
            journal.append(pieces[place], segmenter.latest)
            cuts = segmenter.take(pieces[place])
            killed = number == lives - 1
            write(cuts, segmenter, journal, killed=killed)
            place += 1
            if not killed:
                journal.forget(segmenter.needs_from_s)
        journal.close()
        with next(iter(sorted((tmp_path / "journal").glob("*.jsonl"), reverse=True))).open(
            "a"
        ) as f:
            f.write('{"values": {"i": [[17900')  # a line that the kill cut off
    _alike(sorted(written.values(), key=lambda cut: cut.start_s), WHOLE)
    assert len(list((tmp_path / "journal").glob("*.jsonl"))) < 40


def test_a_gap_ends_a_cut_and_nothing_before_it_is_held_over() -> None:
    said = _values()
    before = [one for one in said if one[0] < BEGIN_S + 4.0]
    after = [one for one in said if one[0] > BEGIN_S + 4.5]
    again: list[Timed] = [(BEGIN_S + 2.0, "feed", 500.0), (BEGIN_S, "mode", "auto")]
    first, second, *others = _cuts([_batch(before), _batch(again + after, gap=True)])
    assert_allclose([first.begin_s - BEGIN_S, first.end_s - BEGIN_S], [2.0, 3.98])
    assert first.cut_off
    assert not second.cut_off
    assert_allclose([second.begin_s - BEGIN_S, second.end_s - BEGIN_S], [4.6, 6.0])
    assert second.start_s == second.begin_s
    assert all(np.isfinite(column).all() for column in second.columns.values())
    _alike(others, WHOLE[1:])


def test_a_cut_that_one_comes_into_begins_where_its_channels_do() -> None:
    """It was said to be on long before, and a channel that stands was said then too."""
    said = [one for one in _values() if one[0] >= BEGIN_S + 3.0]
    state: list[Timed] = [(BEGIN_S - 9.0, "p", 7.0), (BEGIN_S - 5.0, "mode", "auto")]
    cuts = _cuts([_batch([*state, (BEGIN_S + 2.0, "feed", 500.0), *said])])
    assert_allclose([cuts[0].begin_s - BEGIN_S, cuts[0].end_s - BEGIN_S], [3.0, 6.0])
    assert cuts[0].start_s == BEGIN_S + 3.0
    _alike(cuts[1:], WHOLE[1:])


def test_a_machine_that_does_not_know_does_not_cut() -> None:
    said = [*_values(), (BEGIN_S + 3.0, "mode", None)]
    cuts = _cuts([_batch(sorted(said, key=lambda one: one[0]))])
    assert_allclose([cuts[0].begin_s - BEGIN_S, cuts[0].end_s - BEGIN_S], [2.0, 3.0])
    assert len(cuts) == 1


@pytest.mark.parametrize(
    ("condition", "value", "holds"),
    [
        ({"above": 1.0}, 1.0, False),
        ({"above": 1.0}, "1.5", True),
        ({"above": 1.0}, "fast", False),
        ({"above": 1.0, "below": 2.0}, 2.5, False),
        ({"is": "ACTIVE"}, " active", True),
        ({"is": True}, 1.0, True),
        ({"is": True}, "TRUE", True),
        ({"is": 3.0}, "3", True),
        ({"is": "3"}, 3.0, True),
        ({"is": "ACTIVE"}, None, False),
    ],
)
def test_conditions(condition: dict[str, Any], value: Value, holds: bool) -> None:
    assert Condition.model_validate({"item": "e", **condition}).holds(value) == holds


def test_a_line_in_the_middle_that_cannot_be_read_is_a_gap(tmp_path: Path) -> None:
    pieces = list(_pieces(_values(), np.random.default_rng(3)))
    journal, segmenter = Journal(tmp_path), Segmenter(PLAN)
    for batch in pieces:
        journal.append(batch, segmenter.latest)
    journal.close()
    (path,) = tmp_path.glob("*.jsonl")
    lines = path.read_bytes().split(b"\n")
    lines[5] = lines[5][:-20]
    path.write_bytes(b"\n".join(lines))
    said = Journal(tmp_path).read()
    assert said.damaged == 1
    assert [batch.gap for batch in said.batches].count(True) == 1
    assert said.batches[4].gap
    assert said.batches[5:] == pieces[5:]


def test_a_full_disk_under_the_journal_takes_back_nothing(tmp_path: Path) -> None:
    pieces = list(_pieces(_values(), np.random.default_rng(4)))
    journal, segmenter = Journal(tmp_path), Segmenter(PLAN)
    journal.append(pieces[0], segmenter.latest)

    class Full:
        def __init__(self, whole: Any) -> None:
            self._whole = whole

        def write(self, line: bytes) -> int:
            return int(self._whole.write(line[:10]))

        def close(self) -> None:
            self._whole.close()

    assert journal._open is not None
    journal._open.handle = Full(journal._open.handle)
    with pytest.raises(OSError) as raised:
        journal.append(pieces[1], segmenter.latest)
    assert raised.value.errno == errno.ENOSPC
    journal.append(pieces[1], segmenter.latest)
    journal.close()
    assert Journal(tmp_path).read().batches == pieces[:2]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("rate_hz = 0", "rate_hz"),
        ('machine = "m"\nmachin = "m"', "machin"),
        (
            '[channels]\n"x.curent" = "i"',
            "'x.curent' is not a channel name (did you mean x.current",
        ),
        ('[channels]\nt = "i"', "'t' is not a channel name"),
        ("[cut]\nwhile = []", "cut.while"),
        ('[cut]\nwhile = [{item = "e"}]', "'e' needs 'above', 'below' or 'is'"),
        ('[source]\nprotocol = "modbus"\nurl = "u"', "source.protocol"),
        ('tool_number = {item = "T"}', "tool_number and [tools.NUMBER] go together"),
    ],
)
def test_an_agent_file_that_cannot_be_used_is_said(tmp_path: Path, change: str, line: str) -> None:
    parts = {
        "": 'machine = "m"\nrate_hz = 100\n',
        "[source]": '[source]\nprotocol = "opcua"\nurl = "opc.tcp://h"\n',
        "[channels]": '[channels]\n"x.current" = "i"\n',
        "[cut]": '[cut]\nwhile = [{item = "e", is = "ACTIVE"}]\n',
    }
    head = change.splitlines()[0]
    if head in parts:
        parts[head] = f"{change}\n"
    elif head.startswith("rate"):
        parts[""] = f'machine = "m"\n{change}\n'
    elif head.startswith("machine"):
        parts[""] = f"{change}\nrate_hz = 100\n"
    else:
        parts[""] += f"{change}\n"
    path = tmp_path / "agent.toml"
    path.write_text("".join(parts.values()), encoding="utf-8")
    with pytest.raises(UnusableInput) as raised:
        read_agentfile(path)
    assert str(path) in str(raised.value)
    assert line in str(raised.value)


def test_a_control_says_which_program_and_line_a_cut_is_of() -> None:
    """A program that is a number is a text all the same; a line that is none is noted."""
    plan = PLAN.model_copy(
        update={
            "cut": PLAN.cut.model_copy(update={"block": StatedItem(item="line"), "name": "groove"}),
            "recording": WorkSection(program=StatedItem(item="program")),
        }
    )
    for line, noted in (("12", 0), ("-", 1)):
        told = replace(WHOLE[0], said={"recording.program": 1234, "cut.block": line})
        side, notes = side_of(told, plan, Path())
        assert side.recording.program == "1234"
        assert (side.cut.name, side.cut.block) == ("groove", None if noted else 12)
        assert sum("block" in note for note in notes) == noted
