"""A reference mill and its plan of 181 cuts: forces estimated by models, networks and all
together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.fitting.gaussian import NORMAL_95
from autodb.proofs.machines.mill.reference_mill import TRUTH_HZ, MillAxis, draw_mill, swept_axis
from autodb.proofs.machines.mill.reference_mill_moves import AXES, RATE_HZ
from autodb.proofs.machines.mill.reference_milling import ALUMINIUM, C45, STRONGER, TeethLaw
from autodb.proofs.machines.mill.reference_plan import (
    TESTS,
    TRAINING,
    PlannedCut,
    RecordedCut,
    record_planned,
)
from autodb.proofs.runs.mill.mill_ours import identified_mill_axis, mill_recording
from autodb.proofs.runs.mill.mill_run import SCORED, SLOW_HZ
from autodb.proofs.runs.mill.network_summary import (
    ANOTHER,
    BEST,
    DRIVE,
    FEW,
    FOUR,
    FUSED,
    GREY,
    KNOWN,
    NETWORK,
    OWN,
    NetBand,
    NetErrors,
    NetHeld,
)
from autodb.proofs.runs.mill.published_lstm import channels_of_cut, published_network
from autodb.proofs.runs.mill.published_mill import PublishedFourSteps, published_four_steps
from autodb.sensing import fusion
from autodb.sensing.drives.reconstruct import DriveModel, reconstruct
from autodb.sensing.network import learning
from autodb.sensing.network.drive_loads import AxisTables, LoadedDrive
from autodb.sensing.network.greybox import GreyBox, KnownForceRecording
from autodb.sensing.network.stream import network_forces

Array = NDArray[np.float64]
Tables = Mapping[str, AxisTables]

EVERY = 8
"""Of so many recordings one is among the few."""


@dataclass(frozen=True)
class SweptMill:
    """A mill with what its own sweep determined of it."""

    seed: int
    mill: dict[str, MillAxis]
    models: dict[str, DriveModel]
    published: dict[str, PublishedFourSteps]

    @classmethod
    def swept(cls, seed: int) -> "SweptMill":
        """Draw a mill and identify its axes."""
        mill = draw_mill(seed)
        return cls(
            seed,
            mill,
            {name: DriveModel.of(identified_mill_axis(seed, mill[name])) for name in SCORED},
            {
                name: published_four_steps(
                    swept_axis(seed, mill[name]), mill[name].newtons_per_ampere
                )
                for name in SCORED
            },
        )

    def cuts(self, planned: Sequence[PlannedCut], work: TeethLaw = C45) -> list[RecordedCut]:
        """Record cuts of the plan."""
        return [record_planned(self.seed, self.mill, one, work) for one in planned]

    @property
    def drives(self) -> dict[str, LoadedDrive]:
        """Return the models of its axes with their motors' constants."""
        return {
            n: LoadedDrive(one, self.mill[n].newtons_per_ampere) for n, one in self.models.items()
        }


def run_networks(seed: int) -> list[NetErrors | NetHeld | NetBand]:
    """Tell the test cuts of a seed's mill in every way."""
    machine = SweptMill.swept(seed)
    training, tests = machine.cuts(TRAINING), machine.cuts(TESTS)
    box = _box(machine, training)
    tables = box.tables(machine.drives)
    few = _box(machine, training[::EVERY])
    few_tables = few.tables(machine.drives)
    together = _fusions(machine, box, tables, training)
    heard = [_heard(machine, box, tables, cut) for cut in tests]
    better = _better(machine, box, tables, training)
    estimated = {
        FOUR: [_four(machine, cut) for cut in tests],
        DRIVE: [one[0].value_N for one in heard],
        NETWORK: _networks(training, tests),
        GREY: [one[1].value_N for one in heard],
        FEW: [_grey(few, few_tables, cut).value_N for cut in tests],
        FUSED: [_fused(together, one).value_N for one in heard],
        BEST: [one[better].value_N for one in heard],
        KNOWN: [_known(machine, cut) for cut in tests],
    }
    errors = [
        NetErrors(way, cut.planned.cut.name, axis, _rms((force[:, k] - cut.true_N[k])[_rows(cut)]))
        for way, forces in estimated.items()
        for cut, force in zip(tests, forces, strict=True)
        for k, axis in enumerate(SCORED)
    ]
    held = [
        *_held(GREY, OWN, tests, [one[1] for one in heard]),
        *_held(FUSED, OWN, tests, [_fused(together, one) for one in heard]),
    ]
    other = SweptMill.swept(seed + 500)
    cuts, theirs = other.cuts(TESTS), box.tables(other.drives)
    held += _held(GREY, ANOTHER, cuts, [_grey(box, theirs, cut) for cut in cuts])
    for work in (ALUMINIUM, STRONGER):
        cuts = machine.cuts(TESTS, work)
        held += _held(GREY, work.name, cuts, [_grey(box, tables, cut) for cut in cuts])
    return [*errors, *held, *_bands(box, tests, estimated[GREY])]


def _box(machine: SweptMill, cuts: Sequence[RecordedCut]) -> GreyBox:
    seen = [recorded_of(cut) for cut in cuts]
    return learning.train_grey_box(seen, machine.drives, rate_hz=RATE_HZ)


def recorded_of(cut: RecordedCut) -> KnownForceRecording:
    """Return a cut as a grey box is trained on it: the scored axes, and their measured forces."""
    known = {name: cut.force_N[AXES.index(name)] for name in SCORED}
    return KnownForceRecording(_of_axes(cut.channels), known)


def _of_axes(channels: Mapping[str, Array]) -> dict[str, Array]:
    return {n: one for n, one in channels.items() if n.split(".")[0] in (*SCORED, "spindle")}


def _grey(box: GreyBox, tables: Tables, cut: RecordedCut) -> fusion.SensedTogether:
    estimated = network_forces(box, tables, cut.channels)
    return fusion.SensedTogether(estimated.force_N, estimated.sd_N)


def _drive(machine: SweptMill, cut: RecordedCut) -> fusion.SensedTogether:
    """Return the forces (n, 2) of the drive models alone, up to P0's frequency."""
    value, sd = [], []
    for name in SCORED:
        seen = mill_recording(cut.made.axes[name], name)
        load = reconstruct(seen, machine.models[name], bandwidth_hz=TRUTH_HZ)
        scale = machine.mill[name].newtons_per_ampere
        value.append(-scale * load.value)
        sd.append(scale * load.sd)
    return fusion.SensedTogether(np.column_stack(value), np.column_stack(sd))


def _heard(
    machine: SweptMill, box: GreyBox, tables: Tables, cut: RecordedCut
) -> tuple[fusion.SensedTogether, fusion.SensedTogether]:
    return _drive(machine, cut), _grey(box, tables, cut)


def _of_axis(heard: Sequence[fusion.SensedTogether], k: int) -> fusion.SensedTogether:
    return fusion.SensedTogether(
        np.column_stack([one.value_N[:, k] for one in heard]),
        np.column_stack([one.sd_N[:, k] for one in heard]),
    )


def _fusions(
    machine: SweptMill, box: GreyBox, tables: Tables, training: Sequence[RecordedCut]
) -> list[fusion.Fusion]:
    """Return how both go together, by axis, from recordings that the grey box left out."""
    cuts = [training[k] for k in learning.held_out_recordings(len(training))]
    heard = [_heard(machine, box, tables, cut) for cut in cuts]
    return [
        fusion.learn_fusion(
            (DRIVE, GREY), [_of_axis(one, k) for one in heard], [cut.force_N[k] for cut in cuts]
        )
        for k in range(len(SCORED))
    ]


def _better(
    machine: SweptMill, box: GreyBox, tables: Tables, training: Sequence[RecordedCut]
) -> int:
    """Return which of both was nearer in the recordings that the grey box left out."""
    off = np.zeros(2)
    for cut in (training[k] for k in learning.held_out_recordings(len(training))):
        for number, one in enumerate(_heard(machine, box, tables, cut)):
            off[number] += _rms((one.value_N - cut.force_N[: len(SCORED)].T)[_rows(cut)])
    return int(np.argmin(off))


def _fused(
    together: Sequence[fusion.Fusion], heard: Sequence[fusion.SensedTogether]
) -> fusion.SensedTogether:
    made = [fusion.fuse(one, _of_axis(heard, k)) for k, one in enumerate(together)]
    return fusion.SensedTogether(
        np.column_stack([one.value_N for one in made]), np.column_stack([one.sd_N for one in made])
    )


def _four(machine: SweptMill, cut: RecordedCut) -> Array:
    found = []
    for name, model in machine.published.items():
        seen = cut.made.axes[name]
        air_N = model.air_N(seen.motion.x, seen.motion.v, seen.motion.a)
        found.append(air_N - seen.current_A * machine.mill[name].newtons_per_ampere)
    return np.column_stack(found)


def _known(machine: SweptMill, cut: RecordedCut) -> Array:
    return np.column_stack(
        [
            cut.made.air_N[name]
            - cut.made.axes[name].current_A * machine.mill[name].newtons_per_ampere
            for name in SCORED
        ]
    )


def _networks(training: Sequence[RecordedCut], tests: Sequence[RecordedCut]) -> list[Array]:
    """Return what P0's networks estimate of each test (n, 2)."""
    networks = [published_network(training, k) for k in range(len(SCORED))]
    return [
        np.column_stack([network.force_N(channels_of_cut(cut)) for network in networks])
        for cut in tests
    ]


def _rows(cut: RecordedCut) -> NDArray[np.bool_]:
    """Return the rows from where the feed begins to where it leaves the work."""
    made = cut.made
    return np.asarray((made.t >= made.begins_s) & (made.t <= made.ends_s))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _held(
    way: str, of: str, cuts: Sequence[RecordedCut], estimated: Sequence[fusion.SensedTogether]
) -> list[NetHeld]:
    found = []
    for cut, one in zip(cuts, estimated, strict=True):
        rows = _rows(cut)
        for k, axis in enumerate(SCORED):
            half_N = NORMAL_95 * one.sd_N[rows, k]
            share = float(np.mean(np.abs(one.value_N[rows, k] - cut.true_N[k, rows]) <= half_N))
            name = cut.planned.cut.name
            found.append(NetHeld(way, of, name, axis, share, float(np.median(half_N))))
    return found


def _bands(box: GreyBox, cuts: Sequence[RecordedCut], estimated: Sequence[Array]) -> list[NetBand]:
    """Return the power above the coherent band, cut by cut together."""
    found = []
    for k, axis in enumerate(SCORED):
        hz = float(box.cutoff_hz[k])
        power = np.zeros(2)
        for cut, force in zip(cuts, estimated, strict=True):
            rows = _rows(cut)
            power += [_above(force[rows, k], hz), _above(cut.true_N[k, rows], hz)]
        found.append(NetBand(axis, hz, *(power / len(cuts)).tolist()))
    return found


def _above(values: Array, hz: float) -> float:
    """Return the mean square of what is faster than a frequency."""
    slow = signals.lowpass(values, rate_hz=RATE_HZ, cutoff_hz=max(hz, SLOW_HZ))
    return float(np.mean((values - slow) ** 2))
