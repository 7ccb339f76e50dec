"""The studies of ``flangeway reproduce``: published problems computed again, one folder each.

They are no part of the package `flangeway`, which never imports them; only its command ``reproduce`` loads them, from
the checkout or, where flangeway is installed from a wheel, from the folder ``studies`` beside the package.
"""
