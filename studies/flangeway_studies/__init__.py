"""The studies of ``flangeway reproduce``: published problems computed again, a module each.

They are a distribution of their own, `flangeway-studies`. The package `flangeway` does not import them; only its
command ``reproduce`` does.
"""
