"""What the sensors of force over time are called, wherever several are put together."""

DRIVE, NETWORK, TABLE = "drive model", "network", "table dynamometer"
