"""`python -m autodb`: the same as the command `autodb`."""

from autodb.cli import main

main()
