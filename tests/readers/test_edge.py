"""Recordings of a SINUMERIK Edge: a row of all signals in each cycle that it counted."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.errors import UnusableInput
from autodb.readers import edge, open_bases
from tests.conftest import Cli

SIGNALS = [
    {"Name": "Cycle", "Type": "INTEGER", "Axis": "CYCLE", "Address": "CYCLE"},
    {"Name": "ActualAxisPosition", "Type": "DOUBLE", "Axis": "X1", "Address": "ENC_POS|1"},
    {"Name": "Current", "Type": "DOUBLE", "Axis": "X1", "Address": "CURRENT|1"},
    {"Name": "Current", "Type": "DOUBLE", "Axis": "C1", "Address": "CURRENT|4"},
    {"Name": "VelocityFeedForward", "Type": "DOUBLE", "Axis": "X1", "Address": "VEL_FFW|1"},
]


def _recorded(
    rows: list[list[Any]], *, each: int = 7, signals: list[dict[str, str]] = SIGNALS
) -> str:
    header = {"Version": {}, "SignalListHFData": signals, "CycleTimeMs": 2}
    parts: list[dict[str, Any]] = [{"HFBlockEvent": {"GCode": "G1 X10"}}]
    parts += [{"HFData": rows[at : at + each]} for at in range(0, len(rows), each)]
    return json.dumps({"Header": header, "Payload": parts, "Footer": {}})


def _rows(count: int) -> list[list[Any]]:
    return [[900 + n + 5 * (n > 10), 0.5 * n, 1.0 + n, None, 250.0] for n in range(count)]


def test_rows_of_all_cycles_at_the_times_that_were_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(edge, "CHUNK", 64)
    monkeypatch.setattr(edge, "BLOCK_ROWS", 80)
    path = tmp_path / "a.json"
    path.write_text(_recorded(_rows(40)))
    (base,) = open_bases(path)
    assert base.columns == (
        "t", "Cycle CYCLE", "ActualAxisPosition X1", "Current X1", "Current C1",
        "VelocityFeedForward X1",
    )  # fmt: skip
    assert [len(one["t"]) for one in base.blocks(["t"], [])] == [14, 14, 12]
    read = base.read(list(base.columns), ["Current X1"])
    n = np.arange(40)
    assert_allclose(read["t"].astype(float), 0.002 * (n + 5 * (n > 10)), atol=1e-12)
    assert_allclose(read["ActualAxisPosition X1"].astype(float), 0.5 * n)
    assert np.isnan(read["Current C1"].astype(float)).all()


def test_signals_of_one_name_are_told_by_their_addresses(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    signals = [*SIGNALS[1:3], {**SIGNALS[2], "Address": "CURRENT|7"}]
    path.write_text(_recorded([[1.0, 2.0, 3.0]] * 9, signals=signals))
    (base,) = open_bases(path)
    assert base.columns[2:] == ("Current X1 CURRENT|1", "Current X1 CURRENT|7")
    assert_array_equal(base.read(["t"])["t"], 0.002 * np.arange(9))


def test_look_proposes_what_was_measured(cli: Cli) -> None:
    Path("a.json").write_text(_recorded(_rows(40)))
    done = cli("look", "a.json")
    assert done.code == 0
    said = done.out
    assert "x.position" in said and "x.current" in said
    assert "x.velocity" not in said  # of the feed forward
    assert "c.current" not in said  # no number in it


def test_other_json_and_half_a_file_are_refused(refused: Callable[..., str]) -> None:
    for text in ("{}", '{"Header": 5, "Payload": []}', '[{"t": 1, "x": 2}]'):
        Path("a.json").write_text(text)
        assert "JSON, but no recording of a SINUMERIK Edge" in refused("look", "a.json")
    Path("a.json").write_text(_recorded(_rows(40))[:-200])
    assert "not a whole SINUMERIK Edge file" in refused("look", "a.json")
    Path("a.json").write_text(_recorded([*_rows(8), [1.0, 2.0]]))
    assert "a row of other than 5 values" in refused("look", "a.json")
    whole = _recorded(_rows(8))
    for part in ("[1, 2]", '{"HFData": 3}', '{"HFData": [1, 2]}', "7"):
        Path("a.json").write_text(whole.replace('"Payload": [', f'"Payload": [{part}, '))
        assert "not a whole SINUMERIK Edge file" in refused("look", "a.json")


def test_a_row_that_is_no_number_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(_recorded([*_rows(9), [909, "off", 1.0, None, 0.0]]))
    with pytest.raises(UnusableInput, match=r"ActualAxisPosition X1', row 10: 'off'"):
        open_bases(path)[0].read(["ActualAxisPosition X1"])
