"""Sealed logs: recordings of a moving arm with hidden effects and the truth about them."""
