"""What passes have asked of a pair's cuts, and of what evidence: a pass asks only what changed.

An explanation is a function of its evidence: what was sensed in some cuts and stated of them, which
of them are excluded, and what was expected. Where all that is as it was when it was asked last, the
answer is what it was then, and is there already; where there was none, there is none.

That is kept with the pass that asked (``models.RefreshPass``), and compared with the evidence as it
is now: whatever takes back or changes what an inquiry rests on has it made again.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Any

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb import __version__
from autodb.agent.answer.pooled.pooling import ExplainableCuts, PooledCuts
from autodb.store import models

GROWN = 0.1
"""Share of the cuts asked of that must have come to them before what all cuts show is asked again.
Chosen: 40 of 400 cuts. Of excluded cuts one more is enough."""
MOVED = 0.01
"""Share by which expected forces may move meanwhile. Chosen: cuts scatter by several times that."""
PARTS = 10
"""Parts of the cuts of which the mean of what is expected is kept. Chosen."""
MOST_KEPT = 100
"""Inquiries that are kept, those asked last; what is not kept is asked again. Chosen: 40 kB."""
Topic = tuple[int | None, int | None, str | None]


@dataclass(frozen=True)
class KeptInquiry:
    """One inquiry: the ``pair`` whose cuts were explained, and for what they were (``about``).

    None: all of one recording; all that they show. ``since``: the first of the ``recordings``, and
    ``upto``: the last of the ``cuts``, by id; ``evidence``: SHA-256 of what they say;
    ``expected_N``: by channel, of each part of the cuts the mean of what was expected.
    """

    pair: int | None
    about: str | None
    since: int
    upto: int
    cuts: int
    evidence: str
    expected_N: Mapping[str, Sequence[float]]

    @property
    def topic(self) -> Topic:
        """What tells an inquiry from others of a machine."""
        return self.pair, self.since if self.pair is None else None, self.about

    def says_the_same(self, now: "KeptInquiry") -> bool:
        """Say whether the same cuts say ``now`` what they did, and much the same is expected."""
        if self.evidence != now.evidence or self.expected_N.keys() != now.expected_N.keys():
            return False
        then_N = np.array([self.expected_N[name] for name in self.expected_N])
        now_N = np.array([now.expected_N[name] for name in self.expected_N])
        return bool(np.all(np.abs(now_N - then_N) <= MOVED * np.abs(then_N)))


class AskedBefore:
    """The inquiries of a machine that its passes have made, those asked last at the end."""

    def __init__(self, kept: Iterable[Mapping[str, Any]] = ()) -> None:
        found = [KeptInquiry(**row) for row in kept]
        self._asked = {one.topic: one for one in found}

    def about(self, pool: PooledCuts) -> KeptInquiry | None:
        """Return when a pool's pair, or its recording, was last asked for what it is about."""
        return self._asked.get(_topic_of(pool))

    def keep(self, asked: KeptInquiry) -> None:
        """Keep an inquiry in place of the one before it."""
        self._asked.pop(asked.topic, None)
        self._asked[asked.topic] = asked

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The inquiries as a pass keeps them."""
        return [asdict(one) for one in self._asked.values()][-MOST_KEPT:]


def kept_inquiry(
    session: Session, owner: models.Machine, pool: PooledCuts, said: ExplainableCuts
) -> KeptInquiry:
    """Return the inquiry that explaining a pool is, by what its cuts have ``said``."""
    pair, since, about = _topic_of(pool)
    first = pool.recordings[0].id
    return KeptInquiry(
        pair=pair,
        about=about,
        since=first if since is None else since,
        upto=max(cut.id for cut in pool.cuts),
        cuts=len(pool.cuts),
        evidence=_digest(session, owner, pool, said),
        expected_N={
            name: [float(f"{part.mean():.6g}") for part in np.array_split(mean, PARTS) if len(part)]
            for name, mean in sorted(said.expected.channels.items())
            if name != "cut"
        },
    )


def _topic_of(pool: PooledCuts) -> Topic:
    if pool.pair is None:
        return None, pool.recordings[0].id, pool.about
    return pool.pair.id, None, pool.about


def _digest(
    session: Session, owner: models.Machine, pool: PooledCuts, said: ExplainableCuts
) -> str:
    """Return the SHA-256 of what an explanation rests on beside what is expected."""
    ids = sorted(cut.id for cut in pool.cuts)
    excluded = sorted(number for number in pool.excluded if number <= ids[-1])
    decided = _last_decision(session, owner, pool.pair)
    found = sha256(repr((__version__, ids, excluded, list(said.includes), decided)).encode())
    for name, values in sorted(said.sensed.channels.items()):
        found.update(name.encode() + np.ascontiguousarray(values).tobytes())
    found.update(repr(sorted((name, list(v)) for name, v in said.sensed.texts.items())).encode())
    return found.hexdigest()


def _last_decision(session: Session, owner: models.Machine, pair: models.Pair | None) -> int:
    """Return the last decision, by id, on a mismatch of a pair, or on any; 0: there is none."""
    query = (
        select(func.max(models.MismatchDecision.id))
        .join(models.Mismatch, models.Mismatch.id == models.MismatchDecision.mismatch_id)
        .join(models.StoredRecording, models.StoredRecording.id == models.Mismatch.recording_id)
        .where(models.StoredRecording.machine_id == owner.id)
    )
    if pair is not None:
        query = query.where(models.Mismatch.of_pair(pair.id))
    return session.scalar(query) or 0
