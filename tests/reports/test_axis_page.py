"""The page of an axis, its maps, and the versions that say how it drifted."""

from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.field import PLACES, SPEEDS, field
from tests.conftest import Cli
from tests.helpers.screw_axis import COULOMB_A, TWO_AXES, VISCOUS_A, screw_moves, write_moves

Array = NDArray[np.float64]


def _by_speed(values: Array) -> Array:
    """Return the mean of each row of a map, NaN where it has no cell."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=1)
    return np.asarray(np.where(known.any(axis=1), total / np.maximum(known.sum(axis=1), 1), np.nan))


def test_the_field_is_friction_over_place_and_velocity() -> None:
    """Cells of the map hold Coulomb and viscous friction at their own velocities, within 5 %."""
    moves = screw_moves(60, moves=40)
    model = identify(moves)
    found = field(moves, model.axis, model.protocol, model.terms, model.off_law)
    assert found.measured.shape == found.modelled.shape == (2 * SPEEDS, PLACES)
    known = np.isfinite(found.measured)
    assert known.mean() > 0.4
    truth = np.sign(found.velocities) * COULOMB_A + VISCOUS_A * found.velocities
    for values in (found.measured, found.modelled):
        rows = _by_speed(values)
        there = np.isfinite(rows)
        assert there.sum() >= SPEEDS
        assert_allclose(rows[there], truth[there], rtol=0.05)
    assert found.error_share < 0.03


def test_a_model_that_lacks_friction_leaves_it_on_the_map() -> None:
    moves = screw_moves(61, moves=40)
    model = identify(moves)
    lame = tuple(t for t in model.terms if t.term != "coulomb")
    left = field(moves, model.axis, model.protocol, lame, model.off_law).left
    rows, whole = _by_speed(left), np.repeat([-COULOMB_A, COULOMB_A], SPEEDS)
    there = np.isfinite(rows)
    assert there.sum() >= SPEEDS
    assert_allclose(rows[there], whole[there], rtol=0.1)


def test_the_page_shows_maps_terms_and_what_is_not_known(cli: Cli) -> None:
    write_moves(Path("air.csv"), screw_moves(62))
    done = cli("identify", "air.csv", "--page", "axis.html")
    assert done.code == 0, done.err
    assert "page: axis.html" in done.out
    page = Path("axis.html").read_text("utf-8")
    for said in ("Z axis", "Measured [A]", "Modelled [A]", "Residual [A]", "coulomb level",
                 "shortly after a reversal", "Warming is not in this model"):  # fmt: skip
        assert said in page
    assert "http" not in page.split("<main>")[1].split("</main>")[0].replace("http://www.w3", "")
    refused = cli("identify", "air.csv", "--page", "axis.pdf")
    assert refused.code == 2
    assert "does not end in .html" in refused.err


def test_update_goes_on_from_the_last_version_and_lists_them_all(cli: Cli) -> None:
    Path("m.toml").write_text(TWO_AXES, encoding="utf-8")
    for name, seed, friction in (("a.csv", 63, 1.0), ("b.csv", 64, 1.0), ("c.csv", 65, 1.4)):
        write_moves(Path(name), screw_moves(seed, friction=friction))
    assert cli("init").code == 0
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    early = cli("identify", "a.csv", "--update", "--machine", "m")
    assert early.code == 2
    assert "has no version of z.current yet" in " ".join(early.err.split())
    assert cli("identify", "a.csv", "--update").code == 2
    assert cli("identify", "a.csv", "--machine", "m").code == 0
    assert cli("identify", "b.csv", "--machine", "m", "--update").code == 0
    done = cli("identify", "c.csv", "--machine", "m", "--update")
    assert done.code == 0, done.err
    said = " ".join(done.out.split())
    assert "Versions" in said
    for name in ("a.csv", "b.csv", "c.csv"):
        assert name in said.split("Versions")[1]
    assert "moved since version 2: coulomb level" in said
