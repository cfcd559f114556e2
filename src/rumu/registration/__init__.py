"""Two surfaces -> Registration."""
