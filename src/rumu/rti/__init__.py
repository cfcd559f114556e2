"""Relightable images (RTI): a few functions of the lamp's direction for each pixel."""
