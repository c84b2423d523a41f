"""The proof of a mill's networks where PyTorch is installed: listing the proofs does without."""

from autodb.proofs.runs.mill import network_summary
from autodb.sensing.network import need_torch


def run_with_torch(seed: int) -> list[network_summary.Judged]:
    """Run what needs PyTorch; raises UnusableInput where it is not installed."""
    need_torch()
    from autodb.proofs.runs.mill import network_run

    return network_run.run_networks(seed)
