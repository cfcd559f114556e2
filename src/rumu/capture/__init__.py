"""Photographs -> Capture."""
