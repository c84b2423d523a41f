"""A rotating table from its kinematics: matrices differentiated in time, no closed form."""

from collections.abc import Callable

import numpy as np

from tests.helpers.truths import Array, Truth, motion, truth

NOISE = 0.02
"""Share of the channel's rms: P4's repeats differ by 0.9 to 3.7 % (physics.md section 5)."""
RATE_HZ = 100.0
MASS_KG = 30.0
CENTRE_M = np.array([0.02, 0.065, 0.035])
"""P4's own centre of mass (section 5); the mass is that of its sensor and work, rounded."""


def turns() -> tuple[dict[str, Array], Array]:
    """Both axes turn, alone and together; return the inputs and T (n, 3, 3) of every row."""
    a = motion([(0, 1), (1.2, 0.9), (0, 1), (-2.0, 1.1), (0, 2), (1.5, 0.7), (0, 1.5)] * 2,
               rate_hz=RATE_HZ, ramp_s=0.25)  # fmt: skip
    c = motion([(0, 2.5), (3.0, 1.2), (0, 1), (-2.0, 2.5), (0, 1.0)] * 2,
               rate_hz=RATE_HZ, ramp_s=0.25)  # fmt: skip
    n = min(len(a["t"]), len(c["t"]))
    angles = {"angle_x": a["position"][:n], "angle_z": c["position"][:n]}
    turn = about_z(angles["angle_z"]) @ about_x(angles["angle_x"])
    spin = turn @ np.gradient(turn, 1 / RATE_HZ, axis=0).transpose(0, 2, 1)
    omega = np.column_stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
    alpha = np.gradient(omega, 1 / RATE_HZ, axis=0)
    rates = {f"omega_{i}": omega[:, k] for k, i in enumerate("xyz")}
    rates |= {f"alpha_{i}": alpha[:, k] for k, i in enumerate("xyz")}
    return {"t": a["t"][:n], **angles, **rates}, turn


def about_x(angle: Array) -> Array:
    """Matrices (n, 3, 3) of turns about x."""
    return np.array([turned_by(a)[np.ix_((2, 0, 1), (2, 0, 1))] for a in angle])


def about_z(angle: Array) -> Array:
    """Matrices (n, 3, 3) of turns about z."""
    return np.array([turned_by(a) for a in angle])


def turned_by(angle: float) -> Array:
    """Turn about z, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def weight(turn: Array, t: Array) -> Array:
    """Weight in the measuring frame, (n, 3): chips take 1 % of it away while it is measured."""
    mass = MASS_KG * (1.0 - 0.01 * t / t[-1])
    up = np.column_stack([np.zeros_like(t), np.zeros_like(t), mass * 9.80665])
    return np.asarray(np.einsum("nij,nj->ni", turn, up)) - [0.0, 0.0, MASS_KG * 9.80665]


def pull(turn: Array, angle_x: Array) -> Array:
    """Force that moves the mass, (n, 3): m d²/dt²(Tᵀ r) turned back; axes miss by 1 mm."""
    centre = CENTRE_M + 0.001 * np.column_stack([np.sin(angle_x)] * 3)
    place = np.einsum("nji,nj->ni", turn, centre)
    fast = np.gradient(np.gradient(place, 1 / RATE_HZ, axis=0), 1 / RATE_HZ, axis=0)
    return MASS_KG * np.asarray(np.einsum("nij,nj->ni", turn, fast))


def gravity(component: int) -> Callable[[], Truth]:
    """The truth of the weight in one component, beside what the turning pulls."""
    form = "xyz"[component]

    def made() -> Truth:
        inputs, turn = turns()
        loads = {f"table_inertia {form}": pull(turn, inputs["angle_x"])[:, component]}
        effect = weight(turn, inputs["t"])[:, component]
        return truth(f"table_gravity {form}", inputs, loads, effect, within=0.05, noise=NOISE,
                     main=("mass", MASS_KG, 0.03))  # fmt: skip

    return made


def inertia(component: int) -> Callable[[], Truth]:
    """The truth of what the turning mass pulls in one component, beside the weight."""
    form = "xyz"[component]
    shown = "yzx"[component]

    def made() -> Truth:
        inputs, turn = turns()
        loads = {f"table_gravity {form}": weight(turn, inputs["t"])[:, component]}
        effect = pull(turn, inputs["angle_x"])[:, component]
        moment = MASS_KG * CENTRE_M["xyz".index(shown)]
        return truth(f"table_inertia {form}", inputs, loads, effect, within=0.15, noise=NOISE,
                     main=(f"moment_{shown}", moment, 0.15))  # fmt: skip

    return made


def process() -> dict[str, Array]:
    """Cuts and pauses of some minutes: simulated process forces of two components."""
    t = np.arange(0.0, 900.0, 0.5)
    cutting = (t % 200.0 < 120.0).astype(np.float64)
    depth = 1.0 + 0.5 * np.sin(t / 70.0)
    return {
        "t": t,
        "cutting": cutting,
        "force": cutting * 300.0 * depth,
        "y.force": cutting * 500.0 * (1.0 + 0.4 * np.cos(t / 23.0)),
    }


def thermal_drift() -> Truth:
    """Two bodies: chips heat the cover, the cover the crystal, and it cools more slowly."""
    p = process()
    cover, crystal, heat = 0.0, 0.0, np.empty_like(p["t"])
    for i, load in enumerate(p["force"] / 300.0):
        cover += 0.5 * (load - cover) / (15.0 if load > cover else 25.0)
        crystal += 0.5 * (cover - crystal) / 60.0
        heat[i] = 60.0 * crystal
    return truth("thermal_drift", p, {"shear": p["force"]}, heat, within=0.3, noise=NOISE)


def crosstalk() -> Truth:
    """A share of the other component that bends a little with force."""
    p = process()
    effect = 0.03 * p["y.force"] + 2e-6 * p["y.force"] ** 2
    return truth("crosstalk", p, {"shear": p["force"]}, effect, within=0.15, noise=NOISE, of="y",
                 main=("share", 0.031, 0.15))  # fmt: skip


TRUTHS = (*(gravity(i) for i in range(3)), *(inertia(i) for i in range(3)),
          thermal_drift, crosstalk)  # fmt: skip
