"""A printed card that makes a capture of a phone's photographs: markers, scale, grays, place for a ball."""
