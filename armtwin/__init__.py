"""armtwin: a simulation-first digital twin of a planar servo arm watched by one webcam."""
