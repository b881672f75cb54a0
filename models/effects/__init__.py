"""Effects: one file each, gathered by `armtwin.models.catalogue.registry`."""
