"""``python -m flangeway`` is the command ``flangeway``."""

from flangeway.cli import main

main()
