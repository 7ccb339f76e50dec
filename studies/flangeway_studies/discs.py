"""Stresses in discs that are pressed at both ends of a diameter."""

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.types import Floats, floats


def axis_stresses_in_disc(contact: LineContact, depth: ArrayLike, radius: float) -> Floats:
    """Stresses on the line of symmetry of a disc that is pressed at both ends of a diameter (Johnson, 1985, 5.6).

    To those in a half plane are added the even tension ``P / (pi R)`` across the diameter, and along it what the
    opposite contact adds.

    Parameters
    ----------
    contact
        One of the contacts.
    depth
        Depths z below the contact, 0 <= z < 2 R, shape (n,).
    radius
        Radius R of the disc.

    Returns
    -------
    Floats
        As of `LineContact.stresses`, the shear being zero, shape (n, 3).

    """
    z = floats(depth)
    if not (radius > 0.0 and (z < 2.0 * radius).all()):
        raise InputError(
            f"depths up to {z.max():g} in a disc of radius {radius}", "a radius above half of them", "check both"
        )
    result = contact.stresses(0.0, z)
    even = contact.force_per_length / np.pi
    result[..., 0] += even / radius
    result[..., 1] += even * (1.0 / radius - 2.0 / (2.0 * radius - z))
    return result
