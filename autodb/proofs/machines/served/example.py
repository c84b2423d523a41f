"""The agent file of a virtual machine that is served."""

from collections.abc import Callable

from autodb.proofs.machines.served.shift import ServedShift

TURNED = """\
operation = "turn"
"""
MILLED = """\
operation = "side-down"
width_mm = {{item = "{width}"}}
"""
TEXT = """\
machine = "{machine}"
rate_hz = {rate_hz:g}
tool_number = {{item = "{tool}"}}

[source]
protocol = "{protocol}"
url = "{url}"
publish_ms = 50

[channels]
{channels}

[cut]
while = [{{item = "{execution}", is = "ACTIVE"}}]
before_s = 0
after_s = 0
{operation}depth_mm = {{item = "{depth}"}}
feed_mm_min = {{item = "{path_feed}"}}
speed_rpm = {{item = "{commanded_speed}"}}

[recording]
work = {{item = "{work}"}}

[tools.1]
{tool_1}
"""


def agent_text(
    shift: ServedShift, *, machine: str, protocol: str, url: str, item: Callable[[str], str] = str
) -> str:
    """Return the agent file of a shift that is served; ``item`` names a channel or state there.

    The control is active while it feeds, in air before and behind the work too, so that nothing
    beside it is needed.
    """
    names = {name: item(name) for name in shift.states}
    mill = "width" in shift.states
    return TEXT.format(
        machine=machine,
        rate_hz=shift.rate_hz,
        protocol=protocol,
        url=url,
        channels="\n".join(f'"{name}" = "{item(name)}"' for name in shift.columns),
        operation=MILLED.format(**names) if mill else TURNED,
        tool_1='name = "end mill"\ndiameter_mm = 10\nteeth = 2'
        if mill
        else 'name = "carbide insert"',
        **names,
    )
