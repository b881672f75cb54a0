"""Effects: one file each, gathered by `armtwin.models.effects.registry`."""
