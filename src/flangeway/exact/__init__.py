"""Solutions in closed form."""

from flangeway.exact.hertz import LineContact, contact_modulus

__all__ = ["LineContact", "contact_modulus"]
