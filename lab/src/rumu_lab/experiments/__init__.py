"""What the paper measured, on data that exists."""
