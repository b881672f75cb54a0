"""The real bench: what its file says, its limits, and the four methods."""
