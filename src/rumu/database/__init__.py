"""What rumu remembers: tables, the engine that reaches them, and their migrations."""
