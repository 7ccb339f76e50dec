"""The case of a wheelset that stands on straight, level track."""

from typing import ClassVar

from flangeway.cases.wheelset.wheelset_case import WheelsetCase


class WheelsetTangentCase(WheelsetCase):
    """A wheelset on two rails under the weight of the car (Moherdaui 2021, 7.2.1, Figure 90a)."""

    name: ClassVar[str] = "wheelset-tangent"
    title: ClassVar[str] = "A wheelset stands on two rails of straight, level track"
