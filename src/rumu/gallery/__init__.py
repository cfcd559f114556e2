"""Works that are kept and shown."""
