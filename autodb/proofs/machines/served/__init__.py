"""Virtual machines that can be read while they run, over OPC UA or MTConnect, on this computer."""
