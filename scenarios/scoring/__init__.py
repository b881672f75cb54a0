"""Sealed worlds and how well the diagnosis does on them."""
