"""Contact between two surfaces."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import is_finite, refused
from flangeway.contact.enforcement import Enforcement
from flangeway.contact.pairs import Pairing
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.segment_to_segment import SegmentToSegment
from flangeway.contact.surface import Surface
from flangeway.errors import InputError, short
from flangeway.problems import Part
from flangeway.types import Floats

PAIRINGS = "NodeToSegment(...), SegmentToSegment(...) or NodeToNode()"
ENFORCEMENTS = "Penalty(...) or AugmentedLagrange(...) or Multiplier(...) or Barrier(...)"


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact between two surfaces of two parts or of one, without friction or with Coulomb's.

    Of bodies of revolution areas, forces and dissipated work are those of the whole circumference.

    Parameters
    ----------
    secondary
        Surface that gives nodes, or over which gaps are averaged. The one with the finer mesh is the better choice.
    primary
        Surface that gives segments.
    pairing
        How the surfaces are compared.
    enforcement
        How the condition of no penetration is enforced.
    friction
        Coefficient of Coulomb's friction, >= 0, or a `Friction` with one such coefficient. Slip is counted from the
        last converged step, so the answer depends on the path of the motion; see `press`.

    Raises
    ------
    InputError
        If the surfaces have nodes in common or belong to parts of different thickness or hypothesis, if the pairing
        and the enforcement do not go together, if a penalty has no value (the message suggests one for these bodies),
        or if the friction is no number >= 0 or falls with the slip velocity, which statics does not know.

    """

    secondary: Surface
    primary: Surface
    pairing: Pairing
    enforcement: Enforcement
    friction: float | Friction = 0.0

    def __post_init__(self) -> None:
        kinds = {"pairing": (Pairing, PAIRINGS), "enforcement": (Enforcement, ENFORCEMENTS)}
        for name, (kind, allowed) in kinds.items():
            if not isinstance(value := getattr(self, name), kind):
                raise refused("Contact", name, value, allowed, "make one, with its parentheses")
        if self.secondary.part is self.primary.part and np.intersect1d(self.secondary.nodes, self.primary.nodes).size:
            raise InputError(
                f"a contact of {self.primary.part.name!r} with itself, whose surfaces have nodes in common",
                "surfaces of two parts, or two of one part that do not meet",
                "name the edges of both; leave the edges at the common corner out of one of them",
            )
        if self.secondary.part.body.thickness != self.primary.part.body.thickness:
            raise InputError(
                f"a contact of {self._names} with thicknesses {self.secondary.part.body.thickness} and "
                f"{self.primary.part.body.thickness}",
                "one thickness for both",
                "give both bodies the length over which they touch",
            )
        bodies = [part.body for part in self.parts]
        hypotheses = [each.hypothesis or "a plane of unknown strain" for each in bodies]
        known = {each.hypothesis for each in bodies if each.hypothesis is not None}
        if len(known) > 1 or bodies[0].axisymmetric != bodies[1].axisymmetric:
            raise InputError(
                f"a contact of {self._names} in {' and '.join(word.replace('_', ' ') for word in hypotheses)}",
                "both in plane strain, both in plane stress, or both axisymmetric",
                "take one hypothesis for both materials",
            )
        if bodies[0].axisymmetric and isinstance(self.pairing, SegmentToSegment) and self.pairing.weighting == "dual":
            raise InputError(
                f"dual weighting of bodies of revolution {self._names}",
                "weighting='standard': the dual functions average nothing at the axis",
                "leave it out",
            )
        self._refuse_bad_friction()
        mean_area = float(np.mean(self.node_areas))
        self.enforcement.check(self.pairing, self.suggested_penalty, mean_area, self._names)

    @property
    def sides(self) -> tuple[Surface, Surface]:
        """Secondary and primary surface."""
        return self.secondary, self.primary

    @property
    def parts(self) -> tuple[Part, Part]:
        """Parts of the secondary and of the primary surface."""
        return self.secondary.part, self.primary.part

    @property
    def node_areas(self) -> Floats:
        """Areas of the secondary nodes, length times thickness, if the primary faces them all: shape (n_nodes,)."""
        return self.pairing.node_areas(self.secondary)

    @property
    def suggested_penalty(self) -> float:
        """Ten times the larger stiffness over the mean length of the secondary edges, a pressure per length."""
        stiffest = max(part.body.modulus for part in self.parts)
        return 10.0 * stiffest / float(np.mean(self.secondary.edge_lengths))

    @property
    def friction_coefficient(self) -> float:
        """Coefficient of friction, the same at every point and slip."""
        return float(self.friction.limits[0][0]) if isinstance(self.friction, Friction) else float(self.friction)

    def _refuse_bad_friction(self) -> None:
        given = f"Contact(friction={short(self.friction)}) of {self._names}"
        law = self.friction
        if isinstance(law, Friction):
            if not law.constant or len(law.limits[0]) != 1:
                raise InputError(
                    given,
                    "one coefficient that does not depend on the slip velocity: bodies move slowly here",
                    "give a number; flangeway rolls with other laws",
                )
        elif not (is_finite(law) and law >= 0.0):
            raise InputError(given, "a number >= 0", "leave friction out for contact without it")

    @property
    def _names(self) -> str:
        return f"{self.secondary.part.name!r} on {self.primary.part.name!r}"
