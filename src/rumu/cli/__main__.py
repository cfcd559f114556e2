"""`python -m rumu.cli` does what `rumu` does."""

from rumu.cli import main

if __name__ == "__main__":
    main()
