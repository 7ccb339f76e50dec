"""Speed and accuracy beside other programs: ``python -m benchmarks NAME``."""

import os

# as the command line does; it holds for the peers in the same process alike
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
