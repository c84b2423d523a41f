"""A machine as it runs: its values come in, are kept in a journal, and become a recording a cut."""
