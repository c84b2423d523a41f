"""Standard cuts: a protocol is data, its reference forces stand in for a dynamometer."""

from autodb.standard.matching import MATCH, References, reference_forces, rows_of_cut
from autodb.standard.protocol import (
    BarStock,
    BlockStock,
    CutProtocol,
    ReferenceForce,
    StandardCut,
    read_protocol,
    run_order,
    shipped,
)

__all__ = [
    "MATCH",
    "BarStock",
    "BlockStock",
    "CutProtocol",
    "ReferenceForce",
    "References",
    "StandardCut",
    "read_protocol",
    "reference_forces",
    "rows_of_cut",
    "run_order",
    "shipped",
]
