"""Recordings over time and tables of cuts: named channels in our units, read from files."""

from autodb.records.source import ChannelSet, RecordingSource, open_as_stored, open_source, read
from autodb.records.tables import EDGE, CutTable, Recording, edge_codes

__all__ = [
    "EDGE",
    "ChannelSet",
    "CutTable",
    "Recording",
    "RecordingSource",
    "edge_codes",
    "open_as_stored",
    "open_source",
    "read",
]
