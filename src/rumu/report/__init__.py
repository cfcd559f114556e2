"""One self-contained HTML page for an assessment or a surface."""
