"""Newtons an ampere from a known mass: recovered from truth, refused where it does not show."""

from pathlib import Path

import numpy as np

from autodb.records import Recording
from tests.conftest import Cli
from tests.test_faults_of_moves import MACHINE
from tests.test_reconstruct import _recording, _write

NEWTONS_PER_AMPERE = 400.0


def _with_mass(seed: int, mass_kg: float) -> Recording:
    """Return moves of the test's axis with a mass on it: F = m a, 1 kg mm/s² = 1 mN."""
    light = _recording(seed, moves=30)
    a = np.gradient(np.gradient(light["z.position"], light.t_s), light.t_s)
    current = light["z.current"] + mass_kg / 1000.0 * a / NEWTONS_PER_AMPERE
    return Recording(path=light.path, channels={**light.channels, "z.current": current})


def test_a_known_mass_tells_newtons_an_ampere(cli: Cli) -> None:
    Path("m.toml").write_text(MACHINE, encoding="utf-8")
    _write(Path("light.csv"), _recording(70, moves=30))
    _write(Path("heavy.csv"), _with_mass(71, 60.0))
    _write(Path("hardly.csv"), _with_mass(72, 0.5))
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    early = cli("identify", "heavy.csv", "--machine", "m", "--added-mass", "60")
    assert early.code == 2
    assert "z.current has no version" in " ".join(early.err.split())
    assert cli("identify", "light.csv", "--machine", "m").code == 0
    done = cli("identify", "heavy.csv", "--machine", "m", "--added-mass", "60")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    found, percent = (
        float(said.split(a)[1].split(b)[0]) for a, b in ((" is ", " N"), ("± ", " %"))
    )
    assert abs(found / NEWTONS_PER_AMPERE - 1.0) < 1.5 * percent / 100.0
    assert percent < 15.0
    assert cli("trace", "model", "2").code == 2, "nothing is stored"
    hardly = cli("identify", "hardly.csv", "--machine", "m", "--added-mass", "0.5")
    assert hardly.code == 2
    assert "too little to weigh by" in " ".join(hardly.err.split())
    alone = cli("identify", "heavy.csv", "--added-mass", "60")
    assert alone.code == 2
    assert "--added-mass goes with --machine" in alone.err
