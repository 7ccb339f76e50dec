"""The case of a bar's section under torsion, with all constants of the section."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from pydantic import Field

from flangeway.cases.case import Progress, RunnableCase
from flangeway.cases.section.section_run import SectionOptions, SectionRun, find_section, run_section
from flangeway.cases.summary import StatusSummary, Summary
from flangeway.solve import Status


@dataclass(frozen=True, kw_only=True)
class TorsionSummary(Summary):
    """What ``summary.json`` of a section under torsion holds: the keys of the section have its unit."""

    section: dict[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """See `Summary.to_dict`."""
        content = super().to_dict()
        return content.pop("section") | content


@dataclass(frozen=True, eq=False)
class TorsionRun:
    """A section under torsion.

    Parameters
    ----------
    case
        The inputs.
    section
        The section and its constants.
    status
        How it ended.
    summary
        What ``summary.json`` holds.

    """

    case: "TorsionCase"
    section: SectionRun
    status: Status
    summary: TorsionSummary


class TorsionCase(RunnableCase):
    """Warping, shear stresses and the constants of a bundled section or of an outline."""

    name: ClassVar[str] = "torsion"
    title: ClassVar[str] = "A section under torsion: warping, shear stress, and all constants of the section"
    essential: ClassVar[tuple[str, ...]] = ("section", "method", "order")

    section: str = Field("136RE", description="136RE, 136RE-8, 136RE-14, 60E1, or an outline file .toml, .csv, .dxf")
    unit: Literal["mm", "cm", "m", "in", "ft"] | None = Field(
        None, description="unit of a file that does not name one; coordinates are not converted"
    )
    half: bool = Field(False, description="whether a CSV file contains one half only, to be mirrored about x = 0")
    method: Literal["fem", "vem"] = Field("fem", description="fem is triangles, vem is polygons with virtual elements")
    order: int = Field(2, ge=1, le=6, description="order of the elements; fem up to 3")
    size: float | None = Field(
        None, ge=1e-9, le=1e9, description="edge length in the section's unit (default: chosen from the section)"
    )
    poisson: float | None = Field(
        None, ge=0.0, le=0.5, description="Poisson's ratio for the shear centre (default: Trefftz's shear centre)"
    )

    def check(self) -> None:
        """See `RunnableCase.check`."""
        find_section(self.section, unit=self.unit, mirrored=self.half)
        self._options()

    def run(self, progress: Progress = lambda _: None) -> TorsionRun:
        """See `RunnableCase.run`."""
        drawn = find_section(self.section, unit=self.unit, mirrored=self.half)
        found = run_section(drawn, self._options(), progress)
        status = Status(True, "both formulations of torsion are solved", 1)
        summary = TorsionSummary(
            status=StatusSummary(status.converged, status.message),
            case={"name": self.name, **self.model_dump()},
            timings_s=found.summary["timings_s"],
            section=found.summary,
        )
        return TorsionRun(self, found, status, summary)

    def _options(self) -> SectionOptions:
        return SectionOptions(self.size, self.order, self.method, self.poisson)
