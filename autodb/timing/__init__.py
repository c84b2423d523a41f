"""What a recording's time is: its stamps examined, its rows laid out on truly even steps."""

from autodb.timing.examined import examined
from autodb.timing.layout import Layout
from autodb.timing.verdict import StampFinding, Timing

__all__ = ["Layout", "StampFinding", "Timing", "examined"]
