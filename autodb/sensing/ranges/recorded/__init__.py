"""One cut recorded over time with raw phase currents becomes a row of a cut table."""
