"""The webcam: its settings, its pictures, and whether what they show has come to rest."""
