"""NC programs of standard cuts: paths of the tool, what a machine allows, and a control's words."""

from autodb.nc.cut_program import DIALECTS, protocol_program

__all__ = ["DIALECTS", "protocol_program"]
