"""Forces of cuts by hand, from text book formulas alone: no line of the program's is used.

Coefficients: Altintas, Manufacturing Automation, 2nd ed. 2012, oblique cutting with Stabler's rule
and friction and chip ratio of an orthogonal edge at the same normal rake; elements of the edge are
summed as there. Axes are those of the formats' page. A cut is (x, y, z [N], torque [N·m]).
"""

from collections.abc import Mapping
from math import acos, atan, cos, exp, log, pi, radians, sin, sqrt, tan

Law = Mapping[str, float]
Four = tuple[float, float, float, float]
SLICES = 300
STUCK = radians(-30.0)


def widths(law: Law, h: float, v: float, rake: float, i: float) -> tuple[float, float, float]:
    """Return tangential, thrust and along the edge, N/mm, of chip h mm at v m/min, angles rad."""
    thick, fast = log(max(h, 0.01) / 0.1), log(v / 100.0)
    ratio = law["chip_ratio"] * exp(law["chip_ratio_thickness"] * thick)
    tan_beta = tan(radians(law["friction_angle"])) * exp(law["friction_speed"] * fast)
    tau = law["shear_stress"]
    phi = atan(ratio * cos(rake) / (1.0 - ratio * sin(rake)))
    beta = atan(tan_beta * cos(i))
    d = sqrt(cos(phi + beta - rake) ** 2 + tan(i) ** 2 * sin(beta) ** 2)
    k_t = tau / sin(phi) * (cos(beta - rake) + tan(i) * tan(i) * sin(beta)) / d
    k_r = tau / (sin(phi) * cos(i)) * sin(beta - rake) / d
    k_a = tau / sin(phi) * (cos(beta - rake) * tan(i) - tan(i) * sin(beta)) / d
    return k_t * h + law["K_te"], k_r * h + law["K_re"], k_a * h


def turned(
    law: Law, tool: Mapping[str, float], *, feed: float, depth: float, kappa: float, v: float
) -> tuple[float, float, float]:
    """Return against the feed, tangential and off the surface: along nose and straight edge."""
    nose, whole = tool["nose_radius_mm"], (0.0, 0.0, 0.0)
    height = nose * (1.0 - cos(kappa))
    reach = kappa if depth >= height else acos(1.0 - depth / nose)
    arc = [((k + 0.5) * reach / SLICES, nose * reach / SLICES) for k in range(SLICES)]
    straight = (depth - height) / sin(kappa) if depth > height else 0.0
    for q, width in [*arc, (kappa, straight)]:
        t, r, a = widths(
            law, feed * sin(q), v, radians(tool["rake_deg"]), -radians(tool["inclination_deg"])
        )
        parts = (r * sin(q) - a * cos(q), t, r * cos(q) + a * sin(q))
        whole = tuple(w + width * p for w, p in zip(whole, parts, strict=True))  # type: ignore[assignment]
    return whole


def speed_at(radius: float, rpm: float) -> float:
    """Return the speed at a radius, m/min."""
    return 2.0 * pi * radius * rpm / 1000.0


def path(law: Law, tool: Mapping[str, float], cut: Mapping[str, float], inward: float) -> Four:
    """Return a cut outside along a path to the centre: 0 turning, π/2 facing."""
    faces = inward > pi / 4.0
    other = radians(270.0 - tool["kappa_deg"] - tool["included_deg"])
    kappa = other + pi / 2.0 - inward if faces else radians(tool["kappa_deg"]) + inward
    arm = 0.5 * cut["diameter_mm"] + 0.5 * cut["depth_mm"] * cos(inward)
    v = speed_at(arm, cut["speed_rpm"])
    against, t, off = turned(
        law, tool, feed=cut["feed_mm_rev"], depth=cut["depth_mm"], kappa=kappa, v=v
    )
    side = -1.0 if faces else 1.0
    x = against * sin(inward) + side * off * cos(inward)
    z = against * cos(inward) - side * off * sin(inward)
    return x, t, z, t * arm / 1000.0


def bore(law: Law, tool: Mapping[str, float], cut: Mapping[str, float]) -> Four:
    """Return a cut that widens a bore to its diameter: the work pushes the tool to the axis."""
    arm = 0.5 * (cut["diameter_mm"] - cut["depth_mm"])
    against, t, off = turned(
        law, tool, feed=cut["feed_mm_rev"], depth=cut["depth_mm"],
        kappa=radians(tool["kappa_deg"]), v=speed_at(arm, cut["speed_rpm"]),
    )  # fmt: skip
    return -off, t, against, t * arm / 1000.0


def groove(law: Law, tool: Mapping[str, float], cut: Mapping[str, float]) -> Four:
    """Return a cut of a blade's front, as wide as it is, square to the axis."""
    arm, width = 0.5 * cut["diameter_mm"], cut["width_mm"]
    v = speed_at(arm, cut["speed_rpm"])
    t, r, _ = widths(law, cut["feed_mm_rev"], v, radians(tool["rake_deg"]), 0.0)
    return r * width, t * width, 0.0, t * width * arm / 1000.0


def thread(law: Law, tool: Mapping[str, float], cut: Mapping[str, float]) -> Four:
    """Return a pass of a thread of 60°: both flanks, at 30° to the infeed."""
    d, height = cut["depth_mm"], cut["width_mm"]
    arm = 0.5 * cut["diameter_mm"]
    v = speed_at(arm, cut["speed_rpm"])
    length = 2.0 * (height - 0.5 * d) / cos(pi / 6.0)
    t, r, _ = widths(law, d * sin(pi / 6.0), v, radians(tool["rake_deg"]), 0.0)
    return r * length * sin(pi / 6.0), t * length, 0.0, t * length * arm / 1000.0


def milled(
    law: Law, tool: Mapping[str, float], cut: Mapping[str, float], begins: float, ends: float
) -> Four:
    """Return the means over a turn of a mill engaged from an angle to another, feed along x."""
    radius, teeth = 0.5 * tool["diameter_mm"], tool["teeth"]
    v = speed_at(radius, cut["speed_rpm"])
    step = (ends - begins) / SLICES
    x = y = z = torque = 0.0
    for k in range(SLICES):
        phi = begins + (k + 0.5) * step
        t, r, a = widths(
            law, cut["feed_mm_tooth"] * sin(phi), v, radians(tool["rake_deg"]),
            radians(tool["helix_deg"]),
        )  # fmt: skip
        share = teeth * cut["depth_mm"] * step / (2.0 * pi)
        x += share * (-t * cos(phi) - r * sin(phi))
        y += share * (t * sin(phi) - r * cos(phi))
        z += share * a
        torque += share * t * radius / 1000.0
    return x, y, z, torque


def drilled(law: Law, tool: Mapping[str, float], cut: Mapping[str, float]) -> Four:
    """Return both lips of a plain drill, and its chisel edge, at rakes of -30° at least."""
    rim, kappa = 0.5 * tool["diameter_mm"], radians(0.5 * tool["point_angle_deg"])
    web, helix, rpm = tool["web_share"] * rim, radians(tool["helix_deg"]), cut["speed_rpm"]
    step = (rim - web) / SLICES
    thrust = torque = 0.0
    for k in range(SLICES):
        r = web + (k + 0.5) * step
        lean = web / r
        rake = atan(r / rim * tan(helix) / sin(kappa) - lean / sqrt(1 - lean**2) * cos(kappa))
        rake = max(rake, STUCK)
        i = atan(lean * sin(kappa) / sqrt(1.0 - (lean * sin(kappa)) ** 2))
        t, n, a = widths(law, 0.5 * cut["feed_mm_rev"] * sin(kappa), speed_at(r, rpm), rake, i)
        width = 2.0 * step / sin(kappa)
        thrust += width * (n * sin(kappa) - a * cos(kappa))
        torque += width * t * r / 1000.0
    t, n, _ = widths(law, 0.5 * cut["feed_mm_rev"], speed_at(0.5 * web, rpm), STUCK, 0.0)
    return 0.0, 0.0, thrust + 2.0 * web * n, torque + 2.0 * web * t * 0.5 * web / 1000.0
