"""The pages that a browser shows, each a question that somebody in the shop has."""

from autodb.web.pages import (
    browser,
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
    importing, learning, machine,
)  # fmt: skip
"""What has routes; a machine's own page last, because its name may have any form."""
