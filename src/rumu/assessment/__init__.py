"""Registration -> Assessment."""
