"""`autodb` alone: what to do next in this folder."""

from autodb.cli._common import say


def say_next() -> None:
    """Print what the folder has, and which commands go on from there."""
    from autodb.agent.operate.next_steps import next_steps
    from autodb.store import DEFAULT_URL, database_url, file_of, opened_database

    url = database_url(None)
    if url == DEFAULT_URL and not file_of(url).exists():
        say("there is no database in this folder")
        say("  autodb demo                 see the whole job on a sample machine first")
        say("  autodb init                 make a database here")
    else:
        with opened_database(url) as store, store.reading() as session:
            there, steps = next_steps(session)
        say(there)
        for command, why in steps:
            say(f"  {command:<27} {why}")
    say("autodb --help lists all commands, autodb COMMAND --help has examples of one")
