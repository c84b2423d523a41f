"""NC programs of standard cuts: paths of the tool, what a machine allows, and a control's words."""

from autodb.nc.cut_program import protocol_program
from autodb.nc.dialects import DIALECTS

__all__ = ["DIALECTS", "protocol_program"]
