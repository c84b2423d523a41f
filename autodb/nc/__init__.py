"""NC programs of standard cuts: paths of the tool, what a machine allows, and a control's words."""

from autodb.nc.program import DIALECTS, program

__all__ = ["DIALECTS", "program"]
