"""The oracle: renders known surfaces and makes known faults; imports nothing that it judges."""
