"""Cases as they lie in `data/real`: recording, simulation, and the truth that was written down."""

import json

import numpy as np
import pandas as pd

from autodb.proofs.cases.real.full_models import full_model
from autodb.proofs.cases.real.real_case import RealCase, RealSpec
from autodb.proofs.cases.real.real_sources import FOLDERS, axis_of_folder, real_folder

SHOWN = (
    "laas-acc-no_coulomb-kept", "laas-map-no_cogging-kept", "smart-x-no_coulomb-kept",
    "tiago-torso-no_gravity-kept", "tx40-j1-no_inertia-kept", "laas-acc-null",
    "laas-roll-no_cogging-kept", "smart-y-no_coulomb-refit", "tiago-torso-no_coulomb-kept",
    "tx40-j4-no_coulomb-kept", "smart-x-null", "laas-acc-no_inertia-kept",
    "laas-map-no_cogging-refit", "smart-x-no_viscous-kept", "tiago-torso-no_gravity-refit",
    "tx40-j1-no_coulomb-refit", "tiago-torso-null", "laas-acc-no_viscous-kept",
    "smart-x-no_coulomb-refit", "tx40-j4-no_viscous-refit", "tx40-j1-null",
    "laas-acc-no_coulomb-refit", "laas-acc200Hz-no_inertia-kept", "laas-map-null",
    "laas-acc-no_inertia-refit", "laas-acc25Hz-no_inertia-kept", "smart-y-null", "tx40-j4-null",
    "laas-acc40-null", "laas-roll-null", "laas-speed-null",
)  # fmt: skip
"""Folders of axes whose truth can be decided, machines in turn."""


def recording_of(folder: str) -> str:
    """Return the recording that a folder's belongs to: `laas-acc25Hz-…` is of `laas-acc`."""
    return next(name for name in FOLDERS if folder.startswith(name))


def shown_specs() -> list[RealSpec]:
    """Return a case of each folder."""
    return [RealSpec("shown", folder, variant=folder.rsplit("-", 1)[1]) for folder in SHOWN]


def shown_case(spec: RealSpec) -> RealCase:
    """Read a case: its simulation is what is in the folder, its columns are of our own."""
    folder = real_folder("real", spec.recording)
    truth = json.loads((folder / "truth.json").read_text("utf-8"))
    table = pd.read_csv(folder / "simulation.csv")
    axis = axis_of_folder(spec.recording, recording_of(spec.recording))
    concealed, full = truth["concealed"], full_model(axis)
    own = full if concealed is None else full.without(concealed)
    own_peaks = {term: float(np.max(np.abs(own.part(term)))) for term in truth["includes"]}
    sizes = {} if concealed is None else {concealed: float(truth["true_size"])}
    others = [name for name in truth["fair"] if name != concealed]
    return RealCase(
        spec, axis, table[axis.channel].to_numpy(dtype=float), own, float(truth["rms_full"]),
        concealed, sizes | {name: float(truth["true_size"]) for name in others},
        bool(truth["decidable"]), tuple(truth["includes"]), own_peaks,
        tuple(truth["includes"]) if spec.variant == "refit" else (), truth["note"],
    )  # fmt: skip
