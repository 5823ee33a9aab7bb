"""`python -m boom_mj`."""

from boom_mj.cli import main

main()
