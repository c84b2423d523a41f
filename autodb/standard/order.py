"""The order in which standard cuts are made: random in blocks, so that drift falls on all alike."""

from random import Random

from autodb.standard.protocol import CutProtocol, StandardCut


def run_order(protocol: CutProtocol) -> tuple[StandardCut, ...]:
    """Return the cuts in the order of the run; the first is made once more at the end.

    As many blocks as the cut that is repeated least has repeats. Each cut's repeats are spread over
    the blocks as evenly as they divide, and each block is shuffled: a slow drift then falls on all
    cuts alike. The cut that opened the run closes it; the difference of the two is the drift.
    The same seed gives the same order.
    """
    random = Random(protocol.seed)
    blocks = min(cut.repeats for cut in protocol.cut)
    order: list[StandardCut] = []
    for block in range(blocks):
        cuts = [
            cut
            for cut in protocol.cut
            for _ in range(_until(cut, block + 1, blocks) - _until(cut, block, blocks))
        ]
        order += sorted(cuts, key=lambda _: random.random())
    return (*order, order[0])


def _until(cut: StandardCut, block: int, blocks: int) -> int:
    """Return how many repeats of a cut come before a block."""
    return cut.repeats * block // blocks
