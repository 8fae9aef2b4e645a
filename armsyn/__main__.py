"""``python -m armsyn``, and the command ``armsyn``."""

import sys


def main() -> None:
    """Run the command line; Ctrl-C ends it in one line while it is still being imported, too."""
    try:
        from armsyn.cli.main import main as run  # noqa: PLC0415 - which takes a while
    except KeyboardInterrupt:
        sys.stderr.write("armsyn: interrupted\n")
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()
