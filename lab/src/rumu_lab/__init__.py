"""The laboratory of rumu: simulated copies, other methods, and experiments on what the marks are worth."""
