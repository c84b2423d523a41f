"""The pages that a browser shows, each a question that somebody in the shop has."""

from autodb.web.pages import (
    browser,
    edges,
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
    stability,
)

PAGES = (
    browser, machines, mismatches, planner, program, stability, recordings, health, pairs, scores,
    importing, learning, edges, machine,
)  # fmt: skip
"""What has routes; a machine's own page last, because its name may have any form."""
