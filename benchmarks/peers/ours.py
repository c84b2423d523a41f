"""`autodb explain` on the same file: recording and simulation, and nothing else."""

from pathlib import Path

import numpy as np

import autodb
from autodb.explain import explain
from autodb.records.tables import CutTable, Recording
from benchmarks.peers.problem import Answer, Part, Problem

VERSION = f"autodb {autodb.__version__}"


def answer(problem: Problem) -> Answer:
    """Answer a problem; parts are what is called missing."""
    paths = Path("recording.csv"), Path("simulation.csv")
    recording: Recording | CutTable = Recording(paths[0], problem.recording)
    simulation: Recording | CutTable = Recording(paths[1], problem.simulation)
    if problem.table:
        texts = {"operation": ["turn"] * problem.measured.shape[1]}
        recording = CutTable(paths[0], problem.recording, texts)
        simulation = CutTable(paths[1], problem.simulation)
    explained = explain(recording, simulation)
    corrected = np.array([explained.traces[name].corrected for name in problem.names])
    parts = tuple(
        Part(name, cause.term, cause.statement, 1.0)
        for name in problem.names
        for cause in explained.explanation.channels[name].missing
        if cause.kind == "missing"
    )
    return Answer(corrected - problem.simulated, parts)
