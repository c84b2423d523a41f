"""The source of a machine that an agent file names, with the libraries that its protocol needs."""

from importlib import import_module

from autodb.errors import UnusableInput
from autodb.live.agentfile import AgentFile
from autodb.live.source import LiveSource

LIBRARIES = ("asyncua", "httpx")


def source_of(plan: AgentFile) -> LiveSource:
    """Return the source that an agent file names; raises UnusableInput without the extra."""
    for name in LIBRARIES:
        try:
            import_module(name)
        except ImportError:
            raise UnusableInput(f"agent needs {name}; run pip install 'autodb[live]'") from None
    if plan.source.protocol == "opcua":
        from autodb.live.opcua import OpcUa

        return OpcUa(plan)
    from autodb.live.mtconnect import MtConnect

    return MtConnect(plan)
