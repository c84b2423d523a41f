"""The thin shear zone: a resolution of vectors, published numbers, its own gradients and views."""

import numpy as np
from numpy.testing import assert_allclose

from autodb.cutting import kienzle, shear
from autodb.cutting.shear import Edge
from autodb.fitting.gaussian import Gaussian
from tests.helpers.plain_law import PLAIN, Array, theta


def edge(
    thickness_mm: float | Array, *, rake_deg: float = 0.0, inclination_deg: float = 0.0,
    speed_m_min: float = 100.0,
) -> Edge:  # fmt: skip
    """Return elements that differ in thickness alone."""
    thick = np.atleast_1d(np.asarray(thickness_mm, dtype=np.float64))
    one = np.ones_like(thick)
    return Edge(
        thick, speed_m_min * one, np.radians(rake_deg) * one, np.radians(inclination_deg) * one
    )


def test_names_and_coordinates_are_each_others_inverse() -> None:
    assert set(shear.law_values(theta())) == set(PLAIN)
    for name, value in shear.law_values(theta()).items():
        assert_allclose(value, PLAIN[name], rtol=1e-12, atol=1e-15)


def test_coefficients_are_those_of_resolved_vectors() -> None:
    """The force on the tool is one vector: normal to the rake face, and friction along the flow.

    Axes: t across the edge along the work's way, n off the machined surface, e along the edge. The
    vector is as large as its projection on the shear plane is the shear stress times that area.
    """
    for rake_deg in (-6.0, 0.0, 12.0):
        for inclination_deg in (-15.0, 0.0, 8.0, 35.0):
            for flow in (1.0, 0.7):
                at = edge(0.1, rake_deg=rake_deg, inclination_deg=inclination_deg)
                known = theta(flow_angle=flow)
                found = np.array(shear.chip_coefficients(known, at))[:, 0]
                assert_allclose(found, _resolved(known, at, flow), rtol=1e-10, atol=1e-9)


def _resolved(known: Array, at: Edge, flow: float) -> Array:
    """Return force along the work's way, off the surface and along the edge over b h."""
    alpha, i = float(at.rake_rad[0]), float(at.inclination_rad[0])
    ratio, eta = float(shear.chip_ratio(known, at)[0]), flow * i
    phi = np.arctan(ratio * np.cos(alpha) / (1.0 - ratio * np.sin(alpha)))
    into_tool = np.array([np.cos(alpha), -np.sin(alpha), 0.0])
    up_rake = np.array([np.sin(alpha), np.cos(alpha), 0.0])
    along_edge = np.array([0.0, 0.0, 1.0])
    friction = np.tan(np.radians(PLAIN["friction_angle"]))
    force = into_tool + friction * (np.cos(eta) * up_rake + np.sin(eta) * along_edge)

    # An edge of length 1/cos i is 1 mm wide
    plane = np.array([-np.cos(phi), np.sin(phi), 0.0])
    area = 0.1 / np.sin(phi) / np.cos(i)
    force *= PLAIN["shear_stress"] * area / np.hypot(force @ plane, force @ along_edge)
    way = np.array([np.cos(i), 0.0, np.sin(i)])
    beside = np.array([np.sin(i), 0.0, -np.cos(i)])
    return np.array([force @ way, force[1], force @ beside]) / 0.1


def test_an_orthogonal_edge_is_armaregos() -> None:
    """F_c and F_t of a thin shear zone, at three rakes."""
    for rake_deg in (-5.0, 0.0, 10.0):
        at = edge(0.08, rake_deg=rake_deg)
        ratio, alpha = float(shear.chip_ratio(theta(), at)[0]), np.radians(rake_deg)
        phi = np.arctan(ratio * np.cos(alpha) / (1.0 - ratio * np.sin(alpha)))
        beta = np.radians(19.1)
        strength = 613.0 * 0.08 / (np.sin(phi) * np.cos(phi + beta - alpha))
        found = np.array(shear.per_width(theta(), at))[:, 0]
        assert_allclose(found[0], strength * np.cos(beta - alpha) + 24.0, rtol=1e-12)
        assert_allclose(found[1], strength * np.sin(beta - alpha) + 43.0, rtol=1e-12)
        assert_allclose(found[2], 0.0, atol=1e-9)


def test_a_titanium_alloy_cuts_at_its_published_level() -> None:
    """Tangential and thrust coefficients of Ti6Al4V at 12 degrees of rake, orthogonal.

    Of the quoted numbers by hand at h = 0.1 mm: r = 0.8306, φ = 44.48 and β = 22.58 degrees, so
    613 cos 10.58 / (sin 44.48 cos 55.06) and the same with the sine.
    """
    at = edge(0.1, rake_deg=12.0)
    exponent = 0.331 - 0.0082 * 12.0
    ratio = (1.755 - 0.028 * 12.0) * 0.1**exponent
    known = theta(
        chip_ratio=ratio, chip_ratio_thickness=exponent, friction_angle=19.1 + 0.29 * 12.0
    )
    tangential, thrust, _ = (one[0] for one in shear.chip_coefficients(known, at))
    assert_allclose([tangential, thrust], [1502.0, 280.5], rtol=1e-3)


def test_thickness_speed_and_rake_go_as_written() -> None:
    known = theta(shear_stress_speed=-0.1, chip_ratio_speed=0.05, friction_rake=0.8)
    slow, fast = (shear.chip_ratio(known, edge(0.1, speed_m_min=v))[0] for v in (100.0, 200.0))
    assert_allclose(fast / slow, 2.0**0.05, rtol=1e-12)
    thin, thick = shear.chip_ratio(theta(), edge(np.array([0.05, 0.1])))
    assert_allclose(thick / thin, 2.0**0.331, rtol=1e-12)
    fades = theta(edge_mm=0.02, shear_stress=1e-9)
    chips = np.array([0.002, 0.02, 0.4])
    assert_allclose(
        shear.per_width(fades, edge(chips))[0], 24.0 * (1.0 - np.exp(-chips / 0.02)), rtol=1e-6
    )


def test_the_thinnest_chips_have_finite_forces() -> None:
    """However steeply friction and ratio go with thickness: the tangential force grows with h."""
    steep = theta(friction_angle=41.0, friction_thickness=-0.3, chip_ratio=0.34)
    chips = np.geomspace(1e-6, 0.4, 60)
    for force in shear.per_width(steep, edge(chips))[:2]:
        assert np.all(np.isfinite(force))
        assert np.all(np.diff(force) > 0.0)


def test_scalars_are_arrays_and_gradients_are_slopes() -> None:
    chips = np.array([0.03, 0.1, 0.35])
    at = edge(chips, rake_deg=5.0, inclination_deg=10.0, speed_m_min=180.0)
    known = theta(edge_mm=0.01, chip_flow=0.5, K_ae=3.0)
    whole = np.array(shear.per_width(known, at))
    for k, one in enumerate(chips):
        alone = edge(one, rake_deg=5.0, inclination_deg=10.0, speed_m_min=180.0)
        assert_allclose(np.array(shear.per_width(known, alone))[:, 0], whole[:, k], rtol=1e-14)
    slopes = shear.gradient(lambda t: shear.per_width(t, at)[1], known, axes=1)
    for k in range(len(known)):
        step = 1e-5 * (np.arange(len(known)) == k)
        sides = [shear.per_width(known + sign * step, at)[1] for sign in (1.0, -1.0)]
        assert_allclose(slopes[k], (sides[0] - sides[1]) / 2e-5, rtol=1e-6, atol=1e-6)


def test_planners_views_are_of_the_same_law() -> None:
    """A law that is Kienzle's gives its numbers back; a linear edge gives its own."""
    at = kienzle.ViewRange()
    exact = theta(chip_ratio_thickness=0.0, K_te=1e-9, K_re=1e-9, shear_stress_thickness=-0.22)
    view = kienzle.kienzle(Gaussian(exact, np.eye(len(exact)) * 1e-4), at)
    specific = float(shear.per_width(exact, edge(1.0))[0][0])
    assert_allclose(view.posterior.mean, [specific, 0.22], rtol=1e-6)
    assert view.off < 1e-6
    assert np.all(np.diag(view.posterior.covariance) > 0.0)
    flat = theta(chip_ratio_thickness=0.0)
    numbers = kienzle.linear_edge(Gaussian(flat, np.eye(len(flat)) * 1e-4), at).posterior.mean
    tangential, thrust, _ = (one[0] for one in shear.chip_coefficients(flat, edge(0.1)))
    assert_allclose(numbers, [tangential, 24.0, thrust, 43.0], rtol=1e-9)
