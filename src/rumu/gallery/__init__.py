"""The gallery: a catalogue of works with their files."""
