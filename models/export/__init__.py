"""Twins as models that other people's tools load: MJCF and URDF, with a note of what the format cannot hold."""
