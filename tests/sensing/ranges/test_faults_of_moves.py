"""Faults of moves in air are named before anything is fitted; sound axes are let through."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.proofs.cases.axis.axis_cases import draw_axis_case
from autodb.proofs.cases.axis.axis_families import FAMILIES
from autodb.proofs.machines.axis.axes import draw_run
from autodb.proofs.machines.axis.axis import HORIZONTAL, VERTICAL, air_moves
from autodb.records.tables import Recording
from autodb.sensing.ranges.faults import faults_of_moves
from tests.conftest import Cli
from tests.helpers.campaigns import first
from tests.helpers.screw_axis import TWO_AXES, emps_axis, screw_moves, write_moves

Array = NDArray[np.float64]


def _sentences(recording: Recording, axis: str) -> list[str]:
    return [check.sentence for check in faults_of_moves(recording, axis) if not check.passed]


def _turned(recording: Recording) -> Recording:
    return _with(recording, **{"z.current": -recording["z.current"]})


def _with(recording: Recording, **channels: Array) -> Recording:
    return replace(recording, channels={**recording.channels, **channels})


def _dragging(recording: Recording) -> Recording:
    """A brake of 2 A closed from 8 to 13 s."""
    velocity = np.gradient(recording["z.position"], recording.t_s)
    closed = (recording.t_s > 8.0) & (recording.t_s < 13.0)
    sense = np.sign(np.where(np.abs(velocity) > 0.5, velocity, 0.0))
    return _with(recording, **{"z.current": recording["z.current"] + 2.0 * closed * sense})


def _holding(recording: Recording) -> Recording:
    """A brake that holds the axis from 8 to 10 s while the drive pushes with 6 A."""
    closed = (recording.t_s > 8.0) & (recording.t_s < 10.0)
    position, current = recording["z.position"].copy(), recording["z.current"].copy()
    position[closed] = position[np.flatnonzero(closed)[0]]
    current[closed] = 6.0
    return _with(recording, **{"z.position": position, "z.current": current})


def _of_x(recording: Recording) -> Recording:
    """The current of x beside the position of z."""
    other = screw_moves(900 + int(recording.path.stem.split("-")[1]))
    n = min(len(recording), len(other))
    channels = {
        "t": recording.t_s[:n],
        "z.position": recording["z.position"][:n],
        "x.position": other["z.position"][:n],
        "z.current": other["z.current"][:n],
    }
    return Recording(path=recording.path, channels=channels)


FAULTS: list[tuple[Callable[[Recording], Recording], str]] = [
    (_turned, "its sign is reversed; change current_sign"),
    (_dragging, "A more in both directions from"),
    (_holding, "a brake is closed or something is in the way"),
    (_of_x, "z.current follows x, not z"),
]


@pytest.mark.parametrize(("fault", "line"), FAULTS, ids=[fault.__name__ for fault, _ in FAULTS])
def test_each_fault_is_named_on_every_axis(
    fault: Callable[[Recording], Recording], line: str
) -> None:
    """Ten recordings each. A brake that is closed during one direction only may be a load."""
    named = 0
    for seed in range(200, 210):
        said = _sentences(fault(screw_moves(seed, moves=24)), "z")
        named += any(line in sentence for sentence in said)
    assert named >= 9


@pytest.mark.parametrize("n", first(1, [3, 6, 20]))
def test_sound_axes_are_let_through(n: int) -> None:
    """n moves of the test's axis, n drawn axes and slides, one axis for each concealed effect."""
    for seed in range(200, 200 + n):
        assert _sentences(screw_moves(seed), "z") == []
    for seed in range(100_501, 100_501 + n):
        drawn = Recording(path=Path("a"), channels=dict(draw_run(seed).channels))
        assert _sentences(drawn, "x") == []
    for seed in range(4001, 4001 + n // 2):
        for slide in (HORIZONTAL, VERTICAL):
            moves, _ = air_moves(seed, slide=slide)
            assert _sentences(Recording(path=Path("a"), channels=moves), "x") == []
    for seed, family in enumerate(FAMILIES, start=4101):
        case = draw_axis_case(seed, [family.kind], 20.0, family=0)
        hidden = Recording(path=Path("a"), channels=dict(case.channels))
        axis = next(n for n in hidden.channels if n.endswith((".current", ".drive_force")))
        assert _sentences(hidden, axis.split(".")[0]) == [], family.kind


def test_real_axes_are_let_through(emps: Path, pulses: Path) -> None:
    for path in (emps, pulses):
        assert _sentences(emps_axis(path, by_law=False)[0], "x") == []


def _heavy(seed: int) -> Recording:
    """Axis x: four times as heavy, with three times the friction."""
    light = screw_moves(seed)
    v = np.gradient(light["z.position"], light.t_s)
    a = np.gradient(v, light.t_s)
    current = (
        light["z.current"] + 3.0 * 6e-4 * a + 2.0 * 0.7 * np.sign(np.where(np.abs(v) > 0.5, v, 0))
    )
    channels = {"t": light.t_s, "x.position": light["z.position"], "x.current": current}
    return Recording(path=light.path, channels=channels)


def test_a_machine_knows_its_axes_apart(cli: Cli) -> None:
    Path("m.toml").write_text(TWO_AXES, encoding="utf-8")
    write_moves(Path("x.csv"), _heavy(220))
    write_moves(Path("z.csv"), screw_moves(221))
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    assert cli("identify", "x.csv", "--machine", "m").code == 0
    assert cli("identify", "z.csv", "--machine", "m").code == 0
    again = screw_moves(222)
    wrong = {name.replace("z.", "x."): values for name, values in again.channels.items()}
    write_moves(Path("wrong.csv"), Recording(path=Path("w"), channels=wrong))
    done = cli("identify", "wrong.csv", "--machine", "m")
    assert done.code == 2
    assert "these look like moves of axis z, not x" in " ".join(done.err.split())
    assert "version 1" not in cli("trace", "model", "3").out
    write_moves(Path("more.csv"), _heavy(223))
    assert cli("identify", "more.csv", "--machine", "m").code == 0


def test_a_brake_that_drags_all_the_time_is_asked_about(cli: Cli) -> None:
    Path("m.toml").write_text(TWO_AXES, encoding="utf-8")
    write_moves(Path("z.csv"), screw_moves(224))
    write_moves(Path("dragged.csv"), screw_moves(225, friction=3.0))
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    assert cli("identify", "z.csv", "--machine", "m").code == 0
    done = cli("identify", "dragged.csv", "--machine", "m")
    assert done.code == 0, done.err
    assert "a brake that drags, a clamp, or a dry way?" in " ".join(done.out.split())


def test_a_turned_sign_ends_in_one_line_and_nothing_is_stored(cli: Cli) -> None:
    Path("m.toml").write_text(TWO_AXES, encoding="utf-8")
    write_moves(Path("z.csv"), _turned(screw_moves(226)))
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    for arguments in (("identify", "z.csv"), ("identify", "z.csv", "--machine", "m")):
        done = cli(*arguments)
        assert done.code == 2
        assert "z.csv: z.current: friction would drive z" in " ".join(done.err.split())
    assert cli("trace", "recording", "1").code == 2
