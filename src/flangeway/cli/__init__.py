"""The command line: one file for each group of commands.

Exit status 0: done; 1: not converged, a check failed, or a library is missing; 2: the input is wrong; 130: interrupted.
"""

# ruff: noqa: I001 (the order of imports is that of the commands)
import gc
import os
import sys

# dense matrices here are small: on a busy machine the threads of BLAS wait for each other longer than they compute.
# Assembly and sparse factorisation use all cores. Read by OpenBLAS when NumPy is imported; a user's own setting stays.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# pictures go to files: a backend for windows, which a user may have set, is not needed
os.environ["MPLBACKEND"] = "agg"

# what libraries and figures make lives on: to look for garbage each 700 objects, as Python does by default, takes a
# twentieth of a short run
gc.set_threshold(20_000)

try:
    # each adds its commands, in the order in which help lists them
    from flangeway.cli import (
        run_cases as cases,
        batch_commands as batch,
        shape_commands as shapes,
        reproduce_command as reproduce,
    )
    from flangeway.cli.app import app, main
except KeyboardInterrupt:
    print("flangeway: interrupted; nothing was written", file=sys.stderr)
    sys.exit(130)

__all__ = ["app", "batch", "cases", "main", "reproduce", "shapes"]
