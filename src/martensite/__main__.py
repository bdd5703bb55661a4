"""`python -m martensite` is the `martensite` command."""

from martensite.cli import main

main()
