"""``python -m armsyn``."""

from armsyn.cli.main import main

main()
