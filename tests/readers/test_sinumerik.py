"""Traces of a SINUMERIK: what changed is said, each signal at its own interval."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.errors import UnusableInput
from autodb.files.side import stated_side
from autodb.readers import open_bases
from autodb.records import source as records
from tests.helpers.files import write_trace

HEAD = """<?xml version="1.0" encoding="utf-8" ?>
<traceSession version="01.00"><traceCaptureSetup><signalSettings>
<signal key="s1" description="Current"/></signalSettings></traceCaptureSetup>
<traceData dataFrames="2">
"""
SIGNALS = """<dataFrame><frameHeader startTime="2026-01-20T20:01:47.526Z"/>
<dataSignal interval="0.002" id="f1" datapointCount="{fast}" description="Current i(q) (32 bit)"
 name="/Nck/!SD/actCurr32 [u1, 7]"/>
<dataSignal interval="0.004" id="f2" datapointCount="{slow}" description="Actual position value."
 name="/Nck/!SEMA/measPos1 [u1, 7]"/>
<dataSignal interval="0.002" id="f3" datapointCount="{fast}" description="Current i(q) (32 bit)"
 name="/Nck/!SD/actCurr32 [u1, 7]"/>
"""
RECORDS = (
    '<rec time="0.000" f1="1.5" f3="-1"/><rec time="0.002" f2="10"/>'
    '<rec time="0.006" f2="11" f1="1.75"/><rec time="0.008" f3="-2"/>'
)


def _trace(frames: int = 1, cut: int | None = None) -> str:
    frame = f"{SIGNALS.format(fast=5, slow=2)}{RECORDS}</dataFrame>"
    return f"{HEAD}{frame * frames}</traceData></traceSession>"[:cut]


def test_what_is_not_said_again_is_what_it_was(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_text(_trace())
    fast, slow = open_bases(path)
    assert (fast.name, slow.name) == ("2 ms", "4 ms")
    assert fast.columns == ("t", "Current i(q) [u1, 7]", "Current i(q) [u1, 7] f3")
    assert slow.columns == ("t", "Actual position value [u1, 7]")
    read = fast.read(list(fast.columns))
    assert_allclose(read["t"].astype(float), np.arange(5) * 0.002)
    assert_array_equal(read[fast.columns[1]], [1.5, 1.5, 1.5, 1.75, 1.75])
    assert_array_equal(read[fast.columns[2]], [-1.0, -1.0, -1.0, -1.0, -2.0])
    read = slow.read(list(slow.columns))
    assert_allclose(read["t"].astype(float), [0.002, 0.006])
    assert_array_equal(read[slow.columns[1]], [10.0, 11.0])


def test_frames_are_time_bases_of_their_own(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_text(_trace(frames=2))
    names = [base.name for base in open_bases(path)]
    assert names == ["frame 1, 2 ms", "frame 1, 4 ms", "frame 2, 2 ms", "frame 2, 4 ms"]


def test_a_side_file_names_its_signals(tmp_path: Path) -> None:
    t = np.arange(300) * 0.01
    path = write_trace(tmp_path / "a.xml", {"t": t, "Actual position": np.round(9 * t) * 5.0})
    side = stated_side({"x.position": "Actual position"}, where="side")
    read = records.read(path, columns=side)
    assert_allclose(read.channels["x.position"], np.round(9 * t) * 5.0)


def test_what_is_no_trace_is_refused(refused: Callable[..., str], tmp_path: Path) -> None:
    Path("a.xml").write_text("<machine><axis name='x'/></machine>")
    assert "XML, but no trace of a SINUMERIK" in refused("look", "a.xml")
    path = tmp_path / "b.xml"
    path.write_text(_trace(cut=-40))
    with pytest.raises(UnusableInput, match=r"not a whole SINUMERIK trace file \(unclosed"):
        open_bases(path)
