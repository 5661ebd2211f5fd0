"""`python -m rollgait` is the command line."""

from rollgait.cli import main

if __name__ == "__main__":
    main()
