"""How much a case's results change when its mesh is halved."""

from dataclasses import dataclass
from typing import Any

from flangeway.cases.case import Progress
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.cases.wheelset.wheelset_summary import ContactSummary, WheelsetSummary
from flangeway.railway.track.placements import SIDES

MAX_APPROACH_CHANGE = 0.02
MAX_POSITION_CHANGE_MM = 0.2


@dataclass(frozen=True)
class Convergence:
    """Results on a mesh and on one with half of its sizes.

    Parameters
    ----------
    summaries
        Summary of each run, coarse mesh first.

    """

    summaries: tuple[WheelsetSummary, WheelsetSummary]

    @property
    def converged(self) -> bool:
        """Whether both runs converged to contact on both sides."""
        return all(each.status.converged and len(each.contacts) > 0 for each in self.summaries)

    @property
    def within(self) -> bool:
        """Whether both runs converged, and approach and positions changed less than the limits."""
        if not self.converged:
            return False
        changes = self.changes()
        return (
            abs(changes["approach_change"]) < MAX_APPROACH_CHANGE
            and changes["position_change_mm"] < MAX_POSITION_CHANGE_MM
        )

    def changes(self) -> dict[str, float]:
        """Relative changes of approach, pressure and half width; the maximum change of a position in mm."""
        coarse, fine = self.summaries
        pairs = _pairs(coarse, fine)

        def relative(key: str) -> float:
            return max((abs(getattr(b, key) / getattr(a, key) - 1.0) for a, b in pairs), default=float("nan"))

        shifts = [
            abs(getattr(a, key)[axis] - getattr(b, key)[axis])
            for a, b in pairs
            for key in ("rail_position_mm", "wheel_position_mm")
            for axis in (0, 1)
        ]
        before, after = coarse.position.approach_mm, fine.position.approach_mm
        return {
            "approach_change": abs(after / before - 1.0),
            "position_change_mm": max(shifts, default=float("nan")),
            "max_pressure_change": relative("max_pressure_MPa"),
            "half_width_change": relative("half_width_mm"),
        }

    def to_json(self) -> dict[str, Any]:
        """What ``converge.json`` holds."""
        keys = ("status", "position", "residual", "contacts", "bodies", "timings_s")
        summaries = [each.to_dict() for each in self.summaries]
        runs = [{"size_scale": s["case"]["size_scale"]} | {key: s[key] for key in keys} for s in summaries]
        return {
            "within": self.within,
            "changes": self.changes() if self.converged else None,
            "limits": {
                "approach_change": MAX_APPROACH_CHANGE,
                "position_change_mm": MAX_POSITION_CHANGE_MM,
            },
            "runs": runs,
            "case": summaries[0]["case"],
            "versions": summaries[0]["versions"],
        }


def run_halved(case: WheelsetCase, progress: Progress = lambda _: None) -> Convergence:
    """Run a case with its own sizes and with half of them.

    Raises
    ------
    InputError
        If the inputs make no problem that can be solved, or half of `size_scale` is not allowed.

    """
    halved = case.from_values({**case.model_dump(), "size_scale": case.size_scale / 2.0})
    case.problem()
    summaries = []
    for run in (case, halved):

        def labelled(sentence: str, scale: float = run.size_scale) -> None:
            progress(f"size scale {scale:g}: {sentence}")

        summaries.append(run.run(labelled).summary)
    return Convergence((summaries[0], summaries[1]))


def _pairs(coarse: WheelsetSummary, fine: WheelsetSummary) -> list[tuple[ContactSummary, ContactSummary]]:
    """Contacts of both runs, side by side: that with the maximum force of each side."""
    pairs = []
    for side in SIDES:
        one, other = ([c for c in each.contacts if c.side == side] for each in (coarse, fine))
        if one and other:
            pairs.append((max(one, key=lambda c: c.force_kN), max(other, key=lambda c: c.force_kN)))
    return pairs
