"""Recordings: what was measured, in memory and as a folder."""
