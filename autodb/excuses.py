"""Errors that input or surroundings are to blame for, in one line each."""

from autodb.errors import UnusableInput


def excuse(error: Exception) -> str | None:
    """Return the line for an error that input or surroundings are to blame for, else None."""
    if isinstance(error, UnusableInput):
        return str(error)
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{error.strerror or error}"
    return _of_the_database(error)


def _of_the_database(error: Exception) -> str | None:
    """Return the line for what the database cannot do: locked, read-only, full, damaged, away."""
    cause = getattr(error, "orig", error)
    if type(cause).__module__.startswith("psycopg"):
        said = str(cause).splitlines()[0]
        return f"the database: {said}; {_of_a_server(str(getattr(cause, 'sqlstate', None)))}"
    if not type(cause).__module__.startswith("sqlite3"):
        return None
    works = {
        "locked": "when the other program that writes to it is done, it would work",
        "readonly": "a database that may be written would work",
        "full": "more room on the disk would work",
    }
    known = next((text for word, text in works.items() if word in str(cause)), None)
    return f"the database: {cause}; {known or 'autodb doctor says more'}"


def _of_a_server(state: str) -> str:
    """Return what would work after an error of a server, by its SQLSTATE (PostgreSQL, app. A)."""
    works = {
        "None": "when the server answers again, it would work",
        "08": "when the server answers again, it would work",
        "57P": "when the server answers again, it would work",
        "40": "nothing was changed; tried again, it would work",
        "55P03": "when the other program that writes to it is done, it would work",
        "25006": "a database that may be written would work",
        "42501": "a user who may write to its tables would work",
        "53100": "more room on the server's disk would work",
    }
    known = next((text for begin, text in works.items() if state.startswith(begin)), None)
    return known or "autodb doctor says more"
