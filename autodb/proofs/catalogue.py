"""The proofs there are, and running one: seeds 1 to n, each run kept as soon as it is finished."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Generic, TypeVar

from pydantic import TypeAdapter

import autodb
from autodb.errors import UnusableInput, near
from autodb.proofs import generators
from autodb.proofs.reached import ROOT, product_sources
from autodb.proofs.runs import proof_summary
from autodb.proofs.runs.axis import axis_intervals, axis_run, axis_summary
from autodb.proofs.runs.axis.axis_run import AxisModelErrors
from autodb.proofs.runs.explain import explain_summary, left_out, outside_run, outside_summary
from autodb.proofs.runs.explain.explain_score import ScoredCase
from autodb.proofs.runs.found import ProofResult
from autodb.proofs.runs.keeping import (
    commands_run,
    commands_summary,
    day_run,
    day_summary,
    faults_run,
    faults_summary,
    fleet_run,
    fleet_summary,
    flips_run,
    flips_summary,
)
from autodb.proofs.runs.keeping.day_run import DayOutcome
from autodb.proofs.runs.lathe import lathe_run, lathe_summary
from autodb.proofs.runs.lathe.lathe_run import AxisErrors
from autodb.proofs.runs.mill import (
    mill_run,
    mill_summary,
    network_summary,
    networks,
    table_run,
    table_summary,
)
from autodb.proofs.runs.pairs import (
    curve_run,
    curve_summary,
    laws_run,
    laws_summary,
    pair_run,
    published_pairs,
    published_summary,
)
from autodb.proofs.runs.pairs.curve_plans import PlannedPair
from autodb.proofs.runs.real import real_run, real_summary
from autodb.proofs.runs.real.real_score import JudgedReal
from autodb.proofs.runs.run_file import Finished, Origin, digest
from autodb.proofs.runs.score import Judged
from autodb.proofs.runs.stamps import stamps_run, stamps_summary
from autodb.proofs.runs.tables import tables_run, tables_summary
from autodb.proofs.runs.weeks import weeks_run, weeks_summary
from autodb.proofs.runs.weeks.weeks_events import Named
from autodb.proofs.runs.weeks.weeks_run import Foreseen

J = TypeVar("J")


@dataclass(frozen=True)
class Proof(Generic[J]):
    """One proof: its name, what it proves, how many runs it takes, and the generator's modules.

    ``run`` judges what one seed draws; ``kept`` is the form of a finished run in a file; ``score``
    sums up runs in the order of their seeds; ``read`` reads what was written of a score.
    """

    name: str
    what: str
    runs: int
    run: Callable[[int], list[J]]
    kept: TypeAdapter[Finished[J]]
    score: Callable[[Sequence[Finished[J]], Origin], ProofResult]
    read: Callable[[str], ProofResult]
    generator: tuple[ModuleType, ...]

    def origin(self) -> Origin:
        """Return what a run of this proof comes from in this program: what it reaches of it."""
        modules = [Path(str(module.__file__)) for module in self.generator]
        return Origin(
            proof=self.name,
            version=autodb.__version__,
            generator=digest(modules, root=ROOT),
            product=digest(product_sources(self.run.__module__, self.score.__module__), root=ROOT),
        )


PROOFS: tuple[Proof[Any], ...] = (
    Proof(
        name="axis-intervals",
        what="95 % intervals of an identified axis hold the truth of axes drawn at random",
        runs=2000,
        run=axis_intervals.run_axis_intervals,
        kept=TypeAdapter(Finished[Judged]),
        score=proof_summary.intervals_summary_of,
        read=proof_summary.IntervalsSummary.from_json,
        generator=generators.AXES,
    ),
    Proof(
        name="explain",
        what="explain names what a simulation left out, and nothing where nothing is missing",
        runs=3000,
        run=left_out.run_left_out,
        kept=TypeAdapter(Finished[ScoredCase]),
        score=explain_summary.explain_summary_of,
        read=explain_summary.ExplainSummary.from_json,
        generator=generators.CONCEALED,
    ),
    Proof(
        name="explain-outside",
        what="what a simulation has right is not called mistuned, whatever else is missing",
        runs=200,
        run=outside_run.run_outside,
        kept=TypeAdapter(Finished[outside_run.Answered]),
        score=outside_summary.outside_summary_of,
        read=outside_summary.OutsideSummary.from_json,
        generator=generators.OUTSIDE,
    ),
    Proof(
        name="explain-milling",
        what="explain names what a milled waveform's simulation left out, and nothing else",
        runs=192,
        run=left_out.run_mill,
        kept=TypeAdapter(Finished[ScoredCase]),
        score=explain_summary.explain_summary_of,
        read=explain_summary.ExplainSummary.from_json,
        generator=generators.CONCEALED_MILLS,
    ),
    Proof(
        name="day",
        what="a lathe's day: events named in time, none invented, next cuts predicted with terms",
        runs=20,
        run=day_run.run_day,
        kept=TypeAdapter(Finished[DayOutcome]),
        score=day_summary.day_summary_of,
        read=day_summary.DaySummary.from_json,
        generator=generators.DAY,
    ),
    Proof(
        name="weeks",
        what="a shop's weeks: every file of cuts predicted before it comes in, events named",
        runs=40,
        run=weeks_run.run_weeks,
        kept=TypeAdapter(Finished[Foreseen | Named]),
        score=weeks_summary.weeks_summary_of,
        read=weeks_summary.WeeksSummary.from_json,
        generator=generators.WEEKS,
    ),
    Proof(
        name="calibration",
        what="forces of calibrated lathes, on which the published way shows the published errors",
        runs=200,
        run=lathe_run.run_lathe,
        kept=TypeAdapter(Finished[AxisErrors]),
        score=lathe_summary.lathe_summary_of,
        read=lathe_summary.LatheSummary.from_json,
        generator=generators.LATHE,
    ),
    Proof(
        name="stamps",
        what="an axis is identified and explained rightly, or not at all, whatever its time stamps",
        runs=200,
        run=stamps_run.run_stamps,
        kept=TypeAdapter(Finished[stamps_run.JudgedStamps]),
        score=stamps_summary.stamps_summary_of,
        read=stamps_summary.StampsSummary.from_json,
        generator=stamps_run.GENERATOR,
    ),
    Proof(
        name="real",
        what="explain names what a simulation of a real axis left out; needs its recordings",
        runs=real_run.REAL_RUNS,
        run=real_run.run_real,
        kept=TypeAdapter(Finished[JudgedReal]),
        score=real_summary.real_summary_of,
        read=real_summary.RealSummary.from_json,
        generator=real_run.REAL_GENERATOR,
    ),
    Proof(
        name="force-tables",
        what="explain names what a simulation of a published table of forces left out",
        runs=tables_run.TABLES_RUNS,
        run=tables_run.run_force_table,
        kept=TypeAdapter(Finished[JudgedReal]),
        score=tables_summary.tables_summary_of,
        read=tables_summary.TablesSummary.from_json,
        generator=tables_run.TABLES_GENERATOR,
    ),
    Proof(
        name="published-axis",
        what="reference axes are as hard as the published ones: the published way shows its errors",
        runs=20,
        run=axis_run.run_axis_gate,
        kept=TypeAdapter(Finished[AxisModelErrors]),
        score=axis_summary.axis_gate_of,
        read=axis_summary.AxisGate.from_json,
        generator=generators.REFERENCE_AXIS,
    ),
    Proof(
        name="axis-field",
        what="friction field, contour and weight of reference axes, identified by autodb",
        runs=20,
        run=axis_run.run_axes,
        kept=TypeAdapter(Finished[AxisModelErrors]),
        score=axis_summary.fields_of,
        read=axis_summary.Fields.from_json,
        generator=generators.REFERENCE_AXIS,
    ),
    Proof(
        name="published-mill",
        what="reference mills are as hard as the published one: the published way has its errors",
        runs=20,
        run=mill_run.run_mill_gate,
        kept=TypeAdapter(Finished[mill_run.ForceErrors | mill_run.KeptOfAxis]),
        score=mill_summary.mill_gate_of,
        read=mill_summary.MillGate.from_json,
        generator=generators.REFERENCE_MILL,
    ),
    Proof(
        name="mill-forces",
        what="forces in the cuts of reference mills, from the currents of their linear drives",
        runs=20,
        run=mill_run.run_mill_forces,
        kept=TypeAdapter(Finished[mill_run.ForceErrors | mill_run.KeptOfAxis]),
        score=mill_summary.forces_of,
        read=mill_summary.ForcesGate.from_json,
        generator=generators.REFERENCE_MILL,
    ),
    Proof(
        name="mill-networks",
        what="forces in reference mills' cuts: the published network, and a grey box beside it",
        runs=3,
        run=networks.run_with_torch,
        kept=TypeAdapter(Finished[network_summary.Judged]),
        score=network_summary.network_summary_of,
        read=network_summary.Networks.from_json,
        generator=generators.MILL_NETWORKS,
    ),
    Proof(
        name="table",
        what="forces on tables that tilt, whose sensors chips heat: the published way, and ours",
        runs=20,
        run=table_run.run_table,
        kept=TypeAdapter(Finished[table_summary.Judged]),
        score=table_summary.table_summary_of,
        read=table_summary.TableForcesSummary.from_json,
        generator=generators.TABLE,
    ),
    Proof(
        name="faults",
        what="a refresh that is killed loses nothing and counts nothing twice",
        runs=200,
        run=faults_run.run_faults,
        kept=TypeAdapter(Finished[faults_summary.Killed]),
        score=faults_summary.faults_summary_of,
        read=faults_summary.Kills.from_json,
        generator=(),  # what is drawn is when it is killed
    ),
    Proof(
        name="faults-commands",
        what="every command that writes, killed or run twice at once, leaves what it would alone",
        runs=500,
        run=commands_run.run_commands,
        kept=TypeAdapter(Finished[commands_summary.KilledCommand | commands_summary.Twice]),
        score=commands_summary.commands_summary_of,
        read=commands_summary.CommandsSummary.from_json,
        generator=(),  # what is drawn is when it is killed
    ),
    Proof(
        name="flips",
        what="a bit that flips in a database's file is found by doctor and backup",
        runs=200,
        run=flips_run.run_flips,
        kept=TypeAdapter(Finished[flips_summary.Flipped]),
        score=flips_summary.flips_summary_of,
        read=flips_summary.Flips.from_json,
        generator=(),  # what is drawn is which bit
    ),
    Proof(
        name="pairs",
        what="95 % intervals of a pair's next forces, in its operation and in those never cut",
        runs=300,
        run=pair_run.run_pair,
        kept=TypeAdapter(Finished[Judged]),
        score=proof_summary.intervals_summary_of,
        read=proof_summary.IntervalsSummary.from_json,
        generator=generators.PAIRS,
    ),
    Proof(
        name="pair-curve",
        what="few turned cuts teach a pair, and fewer where the next one is proposed",
        runs=48,
        run=curve_run.run_curve,
        kept=TypeAdapter(Finished[curve_run.LearningErrors | PlannedPair]),
        score=curve_summary.curve_summary_of,
        read=curve_summary.CurveSummary.from_json,
        generator=generators.PAIRS,
    ),
    Proof(
        name="pair-laws",
        what="pairs of three other laws: intervals by tool and law, beside plain least squares",
        runs=400,
        run=laws_run.run_laws,
        kept=TypeAdapter(Finished[laws_run.DrawnLaw | laws_run.ForeseenForce]),
        score=laws_summary.laws_summary_of,
        read=laws_summary.LawsSummary.from_json,
        generator=generators.LAW_PAIRS,
    ),
    Proof(
        name="pair-tables",
        what="published tables of forces: few of their cuts teach, beside plain least squares",
        runs=24,
        run=published_pairs.run_tables,
        kept=TypeAdapter(Finished[published_pairs.TabledForce]),
        score=published_summary.published_summary_of,
        read=published_summary.PublishedPairs.from_json,
        generator=generators.TABLED_PAIRS,
    ),
    Proof(
        name="fleet",
        what="a new machine predicts sooner from what others know; one that is off is named",
        runs=50,
        run=fleet_run.run_fleet,
        kept=TypeAdapter(Finished[fleet_run.Joined | fleet_run.NamedOne]),
        score=fleet_summary.fleet_summary_of,
        read=fleet_summary.Fleets.from_json,
        generator=generators.FLEETS,
    ),
)


def proof(name: str) -> Proof[Any]:
    """Return a proof by name; raises UnusableInput naming those there are."""
    found = next((one for one in PROOFS if one.name == name), None)
    if found is None:
        raise UnusableInput(f"no proof '{name}'{near(name, [one.name for one in PROOFS])}")
    return found
