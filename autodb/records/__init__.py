"""Recordings over time and tables of cuts: named channels in our units, read from files."""

from autodb.records.source import ChannelSet, RecordingSource, open_as_stored, open_source, read
from autodb.records.tables import EDGE, CutTable, Recording, edge_codes
from autodb.records.timed import on_even_rows, rows_of_file

__all__ = [
    "EDGE",
    "ChannelSet",
    "CutTable",
    "Recording",
    "RecordingSource",
    "edge_codes",
    "on_even_rows",
    "open_as_stored",
    "open_source",
    "read",
    "rows_of_file",
]
