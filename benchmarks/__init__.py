"""Speed and accuracy beside other programs: ``python -m benchmarks NAME``."""
