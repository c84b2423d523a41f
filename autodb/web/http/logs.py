"""The service's log: one JSON object a line, on the standard error.

What the service counts of itself, as Prometheus reads it.
"""

import json
import logging
import sys
from asyncio import CancelledError
from datetime import UTC, datetime

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.gc_collector import GCCollector
from prometheus_client.platform_collector import PlatformCollector
from prometheus_client.process_collector import ProcessCollector

EXTRA = ("request", "method", "path", "route", "status", "ms", "who", "client")
LOG = logging.getLogger("autodb.web")


class AsJson(logging.Formatter):
    """Formats a record as one line of JSON."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the record: when, how grave, what, and what its request was."""
        said = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "message": record.getMessage(),
        }
        said |= {name: getattr(record, name) for name in EXTRA if hasattr(record, name)}
        if record.exc_info:
            said["error"] = self.formatException(record.exc_info)
        return json.dumps(said, ensure_ascii=False)


def was_cancelled(record: logging.LogRecord) -> bool:
    """Return whether a record is of an answer that was cut off: the server that did it says so."""
    return record.exc_info is not None and isinstance(record.exc_info[1], CancelledError)


def begin_logging() -> None:
    """Have the service and its server log as JSON; requests are logged by the service alone."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(AsJson())
    handler.addFilter(lambda record: not was_cancelled(record))
    for name in ("autodb.web", "uvicorn", "uvicorn.error"):
        logger = logging.getLogger(name)
        logger.handlers[:] = [handler]
        logger.propagate = False
        logger.setLevel(logging.INFO)
    logging.getLogger("uvicorn.access").disabled = True


SECONDS = (0.001, 0.002, 0.003, 0.005, 0.01, 0.015, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30)
TEXT = CONTENT_TYPE_LATEST


class Metrics:
    """Requests by route, method and status with their times; what was refused at the door."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        for collector in (ProcessCollector, PlatformCollector, GCCollector):
            collector(registry=self._registry)
        self.requests = Counter(
            "autodb_requests", "Requests answered.", ("route", "method", "status"),
            registry=self._registry,
        )  # fmt: skip
        self.seconds = Histogram(
            "autodb_request_seconds", "From a request's head to its answer's end.", ("route",),
            buckets=SECONDS, registry=self._registry,
        )  # fmt: skip
        self.running = Gauge(
            "autodb_requests_running", "Requests being answered.", registry=self._registry
        )
        self.refused_tokens = Counter(
            "autodb_refused_tokens", "Tokens that were not valid.", registry=self._registry
        )
        self.cuts = Counter(
            "autodb_cuts_looked_up", "Cuts predicted by look-ups and batches.",
            registry=self._registry,
        )  # fmt: skip
        self.imports = Counter(
            "autodb_imports", "Recordings that were sent, by what became of them.", ("state",),
            registry=self._registry,
        )  # fmt: skip
        self.importing = Gauge(
            "autodb_imports_running", "Recordings that are received, read or wait for it.",
            registry=self._registry,
        )  # fmt: skip

    def text(self) -> bytes:
        """Return all of it as Prometheus reads it."""
        return generate_latest(self._registry)
