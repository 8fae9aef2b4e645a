"""The process of `armsyn.driver.process`: ``python -m armsyn.driver.process_child DESCRIPTOR``."""

from __future__ import annotations

import sys
from multiprocessing.connection import Connection

from armsyn.driver.process import serve

if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
