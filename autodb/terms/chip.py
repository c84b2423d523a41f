"""How hard the work material cuts: factors on the chip's force of each cut.

All are 1 under the stated reference conditions, so that the factor of `shear` keeps its meaning.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import Factor, ParameterPrior, TermParameter

Array = NDArray[np.float64]

REFERENCE_THICKNESS_MM = 0.2
"""Where the size effect is 1: the geometric middle of P1's feeds, 0.1 to 0.4 mm/rev."""
THINNEST_MM = 1e-3
"""Thinner than an edge is sharp, no chip is sheared: the size effect grows no further. Chosen."""
REFERENCE_SPEED_M_MIN = 100.0
"""Speed at which softening is 1: chosen, a round speed for steel."""
SLOWEST_M_MIN = 0.1
"""Slower than any machine cuts: factors of speed change no further. Chosen."""

EDGE_CUTS = 0.5
"""Width of the ends of a hard spot in cuts. Chosen: a search that begins some cuts away still sees
where the end is; with ramps of one cut it stayed up to five cuts away, with wider ones the end
itself was blurred."""


def size_effect(thickness_mm: Array, *, exponent: float) -> Array:
    """The specific force rises as the chip thins: factor (h/h0)^−m, h0 = 0.2 mm, (n,).

    h uncut chip thickness [mm], not below THINNEST_MM; m [-]. Over 0.1-0.4 mm a constant edge force
    gives nearly the same; at h ≤ 0.03 mm it does not. Source: Kienzle's
    k_c = k_c1.1 · h^−m_c, written relative to h0.
    """
    thick = np.maximum(thickness_mm, THINNEST_MM) / REFERENCE_THICKNESS_MM
    return np.asarray(thick**-exponent, dtype=np.float64)


def speed_softening(speed_m_min: Array, *, exponent: float) -> Array:
    """Heat softens the shear zone as speed rises: factor (v/v0)^−e, v0 = 100 m/min, (n,).

    Monotone in speed; e > 0 softens, e < 0 hardens with the rate of strain.
    Source: by construction, strength × (v/v0)^−e.
    """
    fast = np.maximum(speed_m_min, SLOWEST_M_MIN) / REFERENCE_SPEED_M_MIN
    return np.asarray(fast**-exponent, dtype=np.float64)


def built_up_edge(speed_m_min: Array, *, change: float, centre_m_min: float, width: float) -> Array:
    """Work material welded to the edge changes its rake in a band of speeds, (n,).

    Factor 1 + change · exp(−½ (ln(v/v_c)/w)²): it vanishes on both sides of the centre v_c [m/min];
    w [-] the half width in ln v. change < 0 where the built-up edge makes the rake sharper.
    Source: physics of a built-up edge, which needs warm but not hot chips; the bell is chosen.
    """
    off = np.log(np.maximum(speed_m_min, SLOWEST_M_MIN) / centre_m_min) / width
    return np.asarray(1.0 + change * np.exp(-0.5 * off**2), dtype=np.float64)


def hard_spot(cut: Array, *, factor: float, first: float, last: float) -> Array:
    """A run of cuts meets other material: factor 1 outside, `factor` from first to last, (n,).

    1 + (factor − 1)·¼(1 + tanh((cut − first + ½)/w))(1 + tanh((last − cut + ½)/w)), w = EDGE_CUTS:
    the edges lie half a cut outside the first and the last, where 88 % of the change is reached.
    Source: physics of a hard zone, a weld or another batch in the bar; the edges are chosen.
    """
    begun = 1.0 + np.tanh((cut - first + 0.5) / EDGE_CUTS)
    goes_on = 1.0 + np.tanh((last - cut + 0.5) / EDGE_CUTS)
    return np.asarray(1.0 + (factor - 1.0) * 0.25 * begun * goes_on, dtype=np.float64)


SIZE_EFFECT = Factor(
    name="size_effect",
    title="the extra force of thin chips",
    channels=("cuts",),
    inputs=("thickness",),
    function=size_effect,
    shape=(
        TermParameter(
            "exponent", "1", "how steeply the specific force rises as the chip thins", 0.0, 0.9,
            prior=ParameterPrior(0.25, 0.15, "chosen: a rise of 10 to 30 % for half the thickness"),
            keyword="exponent", starts=(0.1, 0.25, 0.5),
        ),
    ),
    modifies=("shear",),
    needs=("cutting.feed",),
    statement="Thin chips cost more force per area than thick ones.",
    excited_by="the same depth and speed at feeds from the thinnest chip to the thickest",
    source="Kienzle's law, k_c = k_c1.1 h^−m_c",
    alike=("edge_force",),
    distinguished_by="Cut at a chip of 0.03 mm or thinner: the edge's force stays, the force of a "
    "thinning chip goes on falling.",
    check="Check whether feed and chip thickness lie below those that the numbers were learnt "
    "from; thin chips take more force for their section, and the same cut at half and at twice the "
    "feed shows it.",
    check_source="Shaw, Metal Cutting Principles, 2nd ed. (2005), chapter 3",
    sits=("material", "tool", "pair"),
    belongs_to="pair",
    in_law=("chip_ratio_thickness", "shear_stress_thickness", "friction_thickness"),
)  # fmt: skip
SPEED_SOFTENING = Factor(
    name="speed_softening",
    title="softening with cutting speed",
    channels=("cuts",),
    inputs=("speed",),
    function=speed_softening,
    shape=(
        TermParameter(
            "exponent", "1", "how steeply force falls with speed; negative: it rises", -0.5, 1.0,
            prior=ParameterPrior(0.0, 0.1, "chosen: the law itself has none"),
            keyword="exponent", starts=(-0.1, 0.1, 0.3),
        ),
    ),
    modifies=("shear",),
    needs=("cutting.speed",),
    statement="The material cuts more easily the faster it is cut.",
    excited_by="the same feed and depth at speeds from the slowest to the fastest",
    source="by construction (power of speed)",
    check="Check the cutting speed that was really run, the override and the coolant; force that "
    "changes steadily with speed goes with the heat of the cut, and the same cut at three speeds "
    "shows it.",
    check_source="Shaw, Metal Cutting Principles, 2nd ed. (2005), chapter 12",
    sits=("material", "pair"),
    belongs_to="pair",
    in_law=("chip_ratio_speed", "shear_stress_speed", "friction_speed"),
)  # fmt: skip
BUILT_UP_EDGE = Factor(
    name="built_up_edge",
    title="a built-up edge",
    channels=("cuts",),
    inputs=("speed",),
    function=built_up_edge,
    shape=(
        TermParameter(
            "change", "1", "relative change of force in the middle of the band", -0.9, 2.0,
            prior=ParameterPrior(0.0, 0.3, "chosen"), keyword="change", starts=(-0.2, 0.2),
        ),
        TermParameter(
            "centre", "m/min", "speed in the middle of the band", 1.0, 300.0,
            prior=ParameterPrior(40.0, 40.0, "chosen: low to middling speeds of steel, aluminium"),
            keyword="centre_m_min", starts=(10.0, 20.0, 40.0, 80.0, 160.0),
        ),
        TermParameter(
            "width", "1", "half width of the band in ln v", 0.05, 1.0,
            prior=ParameterPrior(0.3, 0.2, "chosen"), keyword="width", starts=(0.15, 0.4),
        ),
    ),
    modifies=("shear",),
    needs=("cutting.speed",),
    statement="In a band of speeds material welds to the edge and changes the force; slower and "
    "faster it does not.",
    excited_by="the same feed and depth at closely spaced speeds, and a look at the edge",
    source="physics of a built-up edge; P1 section 2 names the state",
    check="Check edge and finished surface for welded-on work material; within a band of speeds it "
    "may build up, and the same cut clearly below and above that band, or with coolant, shows it.",
    check_source="P1 section 2; Boothroyd and Knight, Fundamentals of Machining and Machine Tools, "
    "section 2.3.2",
    sits=("pair", "material", "tool"),
    belongs_to="pair",
)  # fmt: skip
HARD_SPOT = Factor(
    name="hard_spot",
    title="a hard spot",
    channels=("cuts",),
    inputs=("cut",),
    function=hard_spot,
    shape=(
        TermParameter(
            "factor", "1", "force there against force elsewhere", 0.2, 5.0,
            prior=ParameterPrior(1.0, 0.3, "chosen"), keyword="factor", starts=(0.8, 1.25),
        ),
        TermParameter("first", "1", "number of the first cut in it", keyword="first"),
        TermParameter("last", "1", "number of the last cut in it", keyword="last"),
    ),
    modifies=("shear", "edge_force"),
    needs=(),
    statement="A run of cuts went through harder or softer material.",
    excited_by="the same cut before, in and behind the place",
    source="physics of a zone of other material",
    check="Check the work where those cuts were made, by hardness and by heat number; an "
    "inclusion, a weld, scale or another bar may lie there, and the same cut beside it shows it.",
    check_source="P1 section 2; ISO 6507-1 for hardness",
    sits=("material",),
    belongs_to="lot",
)  # fmt: skip
