"""Which modules make the truth of each proof: a change of any begins its runs anew."""

from autodb.proofs import cases
from autodb.proofs.cases import plan
from autodb.proofs.cases.axis import (
    added_effects,
    axis_cases,
    axis_families,
    changing_effects,
    effect,
    outside,
)
from autodb.proofs.cases.axis import machine as axis_machine
from autodb.proofs.cases.base import build, case, disturbance, moves
from autodb.proofs.cases.cuts import cut_cases, cut_effects, cut_families, cuts
from autodb.proofs.cases.mill import (
    mill_cases,
    mill_effects,
    mill_families,
    mill_plan,
    mill_table_effects,
    milling,
)
from autodb.proofs.cases.tables import published_tables
from autodb.proofs.machines.axis import (
    axes,
    curves,
    motion,
    quantities,
    reference_axis,
    reference_friction,
    reference_moves,
)
from autodb.proofs.machines.lathe import (
    day,
    drives,
    edge_laws,
    fleets,
    jobs,
    lathe,
    law_pairs,
    machine,
    noses,
    power_pairs,
    process,
    reference_lathe,
    weeks,
)
from autodb.proofs.machines.mill import (
    reference_cogging,
    reference_cuts,
    reference_mill,
    reference_mill_moves,
    reference_milling,
    reference_plan,
    reference_ringing,
    reference_table,
)

CONCEALED = (
    cases,
    added_effects,
    axis_cases,
    axis_families,
    build,
    case,
    changing_effects,
    cut_cases,
    cut_effects,
    cut_families,
    cuts,
    disturbance,
    effect,
    axis_machine,
    moves,
    plan,
)
CONCEALED_MILLS = (
    *CONCEALED,
    mill_cases,
    mill_effects,
    mill_families,
    mill_plan,
    mill_table_effects,
    milling,
)
DAY = (day, drives, machine, cases, build, case, cut_effects, cut_families, cuts, moves)
WEEKS = (weeks, drives, jobs, lathe, machine, noses, process)
REFERENCE_AXIS = (curves, motion, reference_axis, reference_friction, reference_moves)
REFERENCE_MILL = (
    curves,
    motion,
    reference_cogging,
    reference_cuts,
    reference_friction,
    reference_mill,
    reference_mill_moves,
    reference_milling,
)
AXES = (axes, curves, motion, quantities)
OUTSIDE = (*CONCEALED, outside)
LATHE = (drives, lathe, machine, process, reference_lathe)
MILL_NETWORKS = (*REFERENCE_MILL, reference_plan)
TABLE = (reference_ringing, reference_table)
PAIRS = (power_pairs, process)
LAW_PAIRS = (edge_laws, law_pairs, power_pairs, process)
TABLED_PAIRS = (published_tables,)
FLEETS = (fleets, power_pairs, process)
