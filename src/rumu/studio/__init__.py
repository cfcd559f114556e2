"""What people do: write, are marked, practise, teach, judge. Knows nothing of HTTP."""
