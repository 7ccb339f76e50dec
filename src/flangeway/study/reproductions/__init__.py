"""Published numbers computed again, a module for each chapter: what ``flangeway reproduce`` computes."""

from flangeway.study.reproductions.common import Reproduced, ReproducedNumber, percent, published_rows, write_rows

__all__ = ["Reproduced", "ReproducedNumber", "percent", "published_rows", "write_rows"]
