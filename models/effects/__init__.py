"""Effects: one file each, gathered by `models.effects.registry`."""
