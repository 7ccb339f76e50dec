"""How much a case's results change when its mesh is halved."""

from dataclasses import dataclass
from typing import Any

from flangeway.cases.case import Progress
from flangeway.cases.wheelset.runner import run_case
from flangeway.cases.wheelset.wheelset_case import WheelsetCase

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

    summaries: tuple[dict[str, Any], dict[str, Any]]

    @property
    def converged(self) -> bool:
        """Whether both runs converged to contact on both sides."""
        return all(s["status"]["converged"] and len(s["contacts"]) > 0 for s in self.summaries)

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
            return max((abs(b[key] / a[key] - 1.0) for a, b in pairs), default=float("nan"))

        shifts = [
            abs(a[key][axis] - b[key][axis])
            for a, b in pairs
            for key in ("rail_position_mm", "wheel_position_mm")
            for axis in (0, 1)
        ]
        before, after = coarse["motion"]["approach_mm"], fine["motion"]["approach_mm"]
        return {
            "approach_change": abs(after / before - 1.0),
            "position_change_mm": max(shifts, default=float("nan")),
            "max_pressure_change": relative("max_pressure_MPa"),
            "half_width_change": relative("half_width_mm"),
        }

    def to_json(self) -> dict[str, Any]:
        """What ``converge.json`` holds."""
        keys = ("status", "motion", "balance", "contacts", "bodies", "timings_s")
        runs = [{"size_scale": s["case"]["size_scale"]} | {key: s[key] for key in keys} for s in self.summaries]
        return {
            "within": self.within,
            "changes": self.changes() if self.converged else None,
            "limits": {
                "approach_change": MAX_APPROACH_CHANGE,
                "position_change_mm": MAX_POSITION_CHANGE_MM,
            },
            "runs": runs,
            "case": self.summaries[0]["case"],
            "versions": self.summaries[0]["versions"],
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

        summaries.append(run_case(run, labelled).summary)
    return Convergence((summaries[0], summaries[1]))


def _pairs(coarse: dict[str, Any], fine: dict[str, Any]) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Contacts of both runs, side by side: the strongest of each side."""

    def strongest(summary: dict[str, Any], side: str) -> dict[str, Any] | None:
        mine = [c for c in summary["contacts"] if c["side"] == side]
        return max(mine, key=lambda c: float(c["force_kN"]), default=None)

    found = [(strongest(coarse, side), strongest(fine, side)) for side in ("left", "right")]
    return [(a, b) for a, b in found if a is not None and b is not None]
