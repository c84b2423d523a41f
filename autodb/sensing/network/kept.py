"""A grey box as bytes: a header in JSON and the weights, with what it was trained on."""

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch

from autodb.errors import UnusableInput
from autodb.sensing.network.drive_loads import SeenAxis
from autodb.sensing.network.greybox import GreyBox, NetworkScaling
from autodb.sensing.network.network import Shape, Stacked

FORMAT = 1
ARRAYS = ("low", "high", "cutoff_hz", "wider")
SCALED = ("middle", "size", "told_N")


@dataclass(frozen=True)
class StoredGreyBox:
    """A grey box, and the checksums of the recordings that it was trained on."""

    box: GreyBox
    trained_on: tuple[str, ...]


def to_bytes(box: GreyBox, trained_on: Sequence[str]) -> bytes:
    """Return a grey box as ``of_bytes`` reads it."""
    header: dict[str, Any] = {
        "format": FORMAT,
        "rate_hz": box.rate_hz,
        "hears": box.hears,
        "seen": box.seen,
        "components": box.components,
        "axes": [asdict(axis) for axis in box.axes],
        "shape": asdict(box.members[0].shape),
        "members": len(box.members),
        "trained_on": list(trained_on),
    }
    arrays = {name: getattr(box, name) for name in ARRAYS}
    arrays |= {name: getattr(box.scaled, name) for name in SCALED}
    for k, member in enumerate(box.members):
        arrays |= {f"{k} {name}": one.numpy() for name, one in member.state_dict().items()}
    written = io.BytesIO()
    np.savez(written, header=np.array(json.dumps(header)), **arrays)
    return written.getvalue()


def of_bytes(kept: bytes) -> StoredGreyBox:
    """Return what ``to_bytes`` wrote; raises UnusableInput for another version's."""
    with np.load(io.BytesIO(kept), allow_pickle=False) as found:
        header = json.loads(str(found["header"]))
        if header["format"] != FORMAT:
            raise UnusableInput(
                f"the network has format {header['format']}, this autodb reads {FORMAT}; train "
                "it again"
            )
        shape = Shape(**header["shape"])
        members = []
        for k in range(header["members"]):
            member = Stacked(shape)
            names = list(member.state_dict())
            member.load_state_dict({n: torch.as_tensor(found[f"{k} {n}"]) for n in names})
            members.append(member.eval())
        arrays = {name: found[name] for name in (*ARRAYS, *SCALED)}
    box = GreyBox(
        rate_hz=header["rate_hz"],
        axes=tuple(_axis(one) for one in header["axes"]),
        hears=header["hears"],
        seen=tuple(header["seen"]),
        components=tuple(header["components"]),
        scaled=NetworkScaling(*(arrays[name] for name in SCALED)),
        members=tuple(members),
        **{name: arrays[name] for name in ARRAYS},
    )
    return StoredGreyBox(box, tuple(header["trained_on"]))


def _axis(kept: dict[str, Any]) -> SeenAxis:
    low, high = kept.pop("travel_mm")
    return SeenAxis(**kept, travel_mm=(low, high))
