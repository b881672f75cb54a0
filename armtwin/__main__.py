"""`python -m armtwin`: the command line."""

from armtwin.scenarios.cli import main

if __name__ == "__main__":
    main()
