"""What is known of strokes, and the master's strokes laid on the copy."""
