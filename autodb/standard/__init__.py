"""Standard cuts: a protocol is data, its reference forces stand in for a dynamometer."""

from autodb.standard.matching import MATCH, References, references, rows_of
from autodb.standard.order import run_order
from autodb.standard.protocol import (
    Bar,
    Block,
    Protocol,
    Reference,
    StandardCut,
    read_protocol,
    shipped,
)

__all__ = [
    "MATCH",
    "Bar",
    "Block",
    "Protocol",
    "Reference",
    "References",
    "StandardCut",
    "read_protocol",
    "references",
    "rows_of",
    "run_order",
    "shipped",
]
