"""Reading the recordings: from where they lie, as channels of an axis in mm, s and A or N.

They are not part of this program: `AUTODB_SHARED` names the folder that holds `data/`.
"""

import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas as pd

from autodb.proofs.cases.real.real_axis import SIGN_WIDTH, Array, RealAxis

VARIABLE = "AUTODB_SHARED"
EMPS_EVERY = 5
"""1 kHz to 200 Hz: five times what its moves need, and answers within seconds."""
EMPS_CROPPED_S = 0.5
"""At either end, as the published protocol has it (Janot, Gautier, Brunot 2019)."""
COUNTS = 8192.0
"""Of the ODrive's encoder, a turn."""
TURN_MM = 10.0
"""A turn is written as 10 mm. Chosen, as a screw of 10 mm pitch would."""
SLOW_HZ, PULL_HZ = 100.0, 200.0
"""Rates of ODrive recordings, whose rows come unevenly: means of what falls into each step."""


class NoRecordingsError(FileNotFoundError):
    """The recordings are not where they are looked for, in one line."""


def real_folder(*parts: str) -> Path:
    """Return a file or folder of the recordings; raises NoRecordingsError where it is missing."""
    root = os.environ.get(VARIABLE)
    if not root:
        raise NoRecordingsError(
            f"{VARIABLE} is not set; set it to the folder whose data/real, data/emps and "
            "data/odrive_cogging hold the recordings"
        )
    path = Path(root, "data", *parts)
    if not path.exists():
        raise NoRecordingsError(f"{path}: missing; {VARIABLE} must name the folder of recordings")
    return path


@cache
def real_axis(name: str) -> RealAxis:
    """Return a recording by its name."""
    return READERS[name](name)


def axis_of_folder(folder: str, name: str) -> RealAxis:
    """Return the recording in a folder of `data/real`, derived as the recording ``name`` is.

    Its effort is a current.
    """
    machine, cutoff_hz, width = FOLDERS[name]
    table = pd.read_csv(real_folder("real", folder, "recording.csv"))
    place = next(column for column in table if str(column).endswith(".position"))
    axis = str(place).split(".")[0]
    values = {str(column): table[column].to_numpy(dtype=float) for column in table}
    return RealAxis(
        name, machine, axis, f"{axis}.current", values["t"], values[f"{axis}.position"],
        values[f"{axis}.current"], cutoff_hz, values.get(f"{axis}.velocity"),
        values.get(f"{axis}.acceleration"), width=width,
    )  # fmt: skip


def _alone(name: str) -> RealAxis:
    return axis_of_folder(f"{name}-null", name)


def _beside(beside: str, name: str) -> RealAxis:
    """Return a recording with the moves of another axis of the machine, as axis y (else x)."""
    own, second = _alone(name), axis_of_folder(f"{beside}-null", name)
    letter = second.axis if second.axis != own.axis else "y"
    moves = {
        f"{letter}.{channel.split('.')[1]}": values
        for channel, values in second.channels.items()
        if channel not in {"t", second.channel}
    }
    return replace(own, other=moves)


def _emps(file: str, name: str, *, loaded: bool = False) -> RealAxis:
    """Return a recording of EMPS: position in mm, force gtau·vir in N.

    Pulses were added to what the controller wanted. Where it is ``loaded`` the effort is what the
    controller wanted alone, and the pulses are a load from outside.
    """
    from scipy.io import loadmat
    from scipy.signal import decimate

    held = loadmat(real_folder("emps", file))
    raw = {key: np.ravel(held[key]).astype(float) for key in ("t", "qm", "vir")}
    few = partial(decimate, q=EMPS_EVERY, ftype="fir", zero_phase=True)
    t = raw["t"][::EMPS_EVERY]
    inside = (t >= t[0] + EMPS_CROPPED_S) & (t <= t[-1] - EMPS_CROPPED_S)
    wanted, load = few(raw["vir"]), None
    if loaded:
        pulses = few(np.ravel(held["pulses_N"]).astype(float))
        wanted, load = wanted - pulses, -pulses / np.max(pulses)
    force = float(held["gtau"].item()) * wanted
    return RealAxis(
        name, "EMPS", "x", "x.drive_force", t[inside], 1000.0 * few(raw["qm"])[inside],
        force[inside], 40.0, load=None if load is None else load[inside],
    )  # fmt: skip


def _odrive(file: str, rate_hz: float, from_s: float, to_s: float, name: str) -> RealAxis:
    """Return a stretch of an ODrive recording: 8192 counts are a turn, written as 10 mm."""
    t, counts, current = np.load(real_folder("odrive_cogging", file)).astype(float)
    inside = (t >= from_s) & (t < to_s)
    step = np.floor((t[inside] - from_s) * rate_hz).astype(int)
    rows = np.arange(step.max() + 1)
    some = np.bincount(step, minlength=len(rows))

    def means(values: Array) -> Array:
        sums = np.bincount(step, values[inside], minlength=len(rows))
        return np.interp(rows, rows[some > 0], sums[some > 0] / some[some > 0])

    return RealAxis(
        name, "ODrive", "x", "x.current", (rows + 0.5) / rate_hz,
        means(counts) * TURN_MM / COUNTS, means(current), 0.1 * rate_hz,
    )  # fmt: skip


FOLDERS = {
    "laas-acc": ("LAAS", 20.0, 0.1),
    "laas-map": ("LAAS", 0.2, SIGN_WIDTH),
    "laas-roll": ("LAAS", 100.0, SIGN_WIDTH),
    "laas-speed": ("LAAS", 60.0, 0.1),
    "smart-x": ("SMART", 3.0, 0.1),
    "smart-y": ("SMART", 3.0, 0.1),
    "tiago-torso": ("TIAGo", 10.0, SIGN_WIDTH),
    "tx40-j1": ("TX40", 15.0, SIGN_WIDTH),
    "tx40-j4": ("TX40", 15.0, SIGN_WIDTH),
}
"""Machine, cutoff of derivatives in Hz, width of the direction of motion; of what is in `real`.

Chosen: the width, from 0.02 and 0.1, whose full model predicts the effort better.
"""
READERS: dict[str, Callable[[str], RealAxis]] = {
    "laas-acc": _alone,
    "laas-map": _alone,
    "laas-roll": _alone,
    "laas-speed": _alone,
    "smart-x": partial(_beside, "smart-y"),
    "smart-y": partial(_beside, "smart-x"),
    "tiago-torso": _alone,
    "tx40-j1": partial(_beside, "tx40-j4"),
    "tx40-j4": partial(_beside, "tx40-j1"),
    "emps": partial(_emps, "DATA_EMPS.mat"),
    "emps-pulses": partial(_emps, "DATA_EMPS_PULSES.mat"),
    "emps-loaded": partial(_emps, "DATA_EMPS_PULSES.mat", loaded=True),
    "odrive-slow": partial(_odrive, "slow2_slower/nocomp_0.npy", SLOW_HZ, 0.5, 33.3),
    "odrive-slow-fed": partial(_odrive, "slow2_slower/comp_0.npy", SLOW_HZ, 0.5, 33.3),
    "odrive-beside": partial(_odrive, "slow2_slower/crosstalk_nocomp_0.npy", SLOW_HZ, 0.5, 33.3),
    "odrive-beside-fed": partial(_odrive, "slow2_slower/crosstalk_comp_0.npy", SLOW_HZ, 0.5, 33.3),
    "odrive-pull": partial(_odrive, "pull_tests/uncomp_slow_0.npy", PULL_HZ, 2.0, 29.9),
    "odrive-pull-fed": partial(_odrive, "pull_tests/comp_slow_0.npy", PULL_HZ, 0.5, 38.0),
    "odrive-pull-fast": partial(_odrive, "pull_tests/uncomp_fast_0.npy", PULL_HZ, 0.0, 3.9),
    "odrive-pull-fast-fed": partial(_odrive, "pull_tests/comp_fast_0.npy", PULL_HZ, 0.0, 3.9),
}
"""How each recording is read."""
