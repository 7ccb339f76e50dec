"""How many threads the compiled core may use."""

import os

from flangeway.errors import InputError, short

VARIABLES = ("RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS")
MOST_THREADS = 256
"""More threads than this take longer to start than they save."""


def refuse_many_threads() -> None:
    """Refuse numbers of threads in the environment with which the core would hang before it begins."""
    for name in VARIABLES:
        value = os.environ.get(name, "")
        if value and not (value.isdecimal() and int(value[:9]) <= MOST_THREADS):
            raise InputError(
                f"{name} = {short(value)}",
                f"a whole number from 0 up to {MOST_THREADS}",
                "leave it out to use all cores",
            )
