"""Capture or one image -> Surface."""
