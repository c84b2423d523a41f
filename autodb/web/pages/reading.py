"""What the pages share that show what the database has."""

from collections.abc import Callable
from typing import TypeVar

from fastapi import Request
from sqlalchemy.orm import Session

from autodb.web.service import service_of

Found = TypeVar("Found")


def read_state(request: Request, asked: Callable[[Session], Found]) -> Found:
    """Return what is asked of one state of the database."""
    with service_of(request).store.reading() as session:
        return asked(session)
