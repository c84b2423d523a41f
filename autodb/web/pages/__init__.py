"""The pages that a browser shows, each a question that somebody in the shop has."""

from autodb.web.pages import (
    choosing,
    health,
    importing,
    learning,
    machine,
    machines,
    mismatches,
    pairs,
    planner,
    program,
    recordings,
    scores,
    signing,
    stability,
)

PAGES = (
    signing, machines, mismatches, planner, program, stability, recordings, health, pairs, scores,
    importing, learning, choosing, machine,
)  # fmt: skip
"""What has routes; a machine's own page last, because its name may have any form."""
