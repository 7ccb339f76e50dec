"""What the live page asks for: profiles, rigid contact over the lateral position, and positions with their patches.

The same inputs go through the same case as ``flangeway run wheelset``, so that the numbers are the same to the last
digit. Sections and their compliance are kept between positions, as in a campaign.
"""

import os
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic.fields import FieldInfo

from flangeway.cases.case import OF_REPORT
from flangeway.cases.case_file import (
    FILE_KEYS,
    MAX_PREPARED,
    bodies_key,
    case_content,
    hash_of,
    toml_text,
    write_case_file,
)
from flangeway.cases.wheelset.wheelset_case import SpatialWheelsetRun, Wheelset
from flangeway.errors import FlangewayError, InputError, short
from flangeway.railway.profiles.bundled import REFERENCE_RAIL, REFERENCE_WHEELS, SECTIONS, WHEELS
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import READABLE, read_profile
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import SIDE_SIGN, SIDES
from flangeway.railway.track.wheelset_problem import Spatial
from flangeway.records import TAG, GivenText, Record, allowed, are_tables, default_text, records_in, with_settings
from flangeway.report.case_outputs import case_record
from flangeway.report.figures.drawing import png
from flangeway.report.page.html_page import command_line, report_page
from flangeway.report.wheelset.wheelset_files import patch_map
from flangeway.report.wheelset.wheelset_page import below_fields, results_table, spatial_facts, stresses_below
from flangeway.system.disk_cache import LatestValues
from flangeway.system.output_folder import write_together
from flangeway.types import Floats, Progress, floats
from flangeway.units import Units, us_key, us_unit

T = TypeVar("T")

LATERAL_MM, STEP_MM = 12.0, 0.05
"""Lateral positions of the rigid contact: how far to both sides, and their distance; the page interpolates between."""
AMPLITUDES_MM = np.arange(0.5, 8.01, 0.25)
"""Amplitudes of the conicity; those beyond the reach of the wheelset are left out."""
OUTLINE_MM = 0.05
"""Deviation of the drawn outlines from arcs, which is less than a pixel."""
LATERAL_POSITIONS = "position.lateral_mm = { from = -6, to = 6, n = 25 }"
"""Positions that a saved campaign computes."""
GROUPS = {
    "track": "Track and supports",
    "wheelset": "Wheels and axle",
    "load": "Load and curve",
    "material": "Material",
    "position": "Position",
    "rolling": "Rolling and friction",
    "contact": "Contact",
    "mesh": "Elements",
}
"""Captions of the form by the tables of the inputs."""
MAX_GEOMETRIES = 12
"""Rigid geometries that are kept; each takes some hundred kilobytes."""
TABLES = (".csv",)
"""Endings of tables of friction along the track."""
MAX_NAME = 200
"""Letters of the name of a dropped file."""
MAX_FILE_BYTES = 20_000_000
"""Size of a dropped file: measured profiles have some hundred kilobytes, files of slices a few megabytes."""


class SupersededError(FlangewayError):
    """A newer request has made a computation useless."""


@dataclass(eq=False)
class LiveEngine:
    """Answers of the page, as plain numbers and texts.

    Parameters
    ----------
    folder
        Where dropped files are kept, only as long as the page is served.
    files
        Profiles that the user gave, by the names that the page uses for them; no other file is read.
    units
        Units of the form and of what is shown; answers of rigid contact and numbers of pictures are metric.

    """

    folder: Path
    files: dict[str, Path] = field(default_factory=dict)
    units: Units = "metric"
    _newest: int = 0
    _computing: threading.Lock = field(default_factory=threading.Lock)
    # one thread for each kind of work: the memory that a thread has freed serves no other one
    _positions: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1))
    _rigid: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1))
    _bodies: LatestValues[Any] = field(default_factory=lambda: LatestValues(MAX_PREPARED))
    _geometries: LatestValues[dict[str, Any]] = field(default_factory=lambda: LatestValues(MAX_GEOMETRIES))

    def form(self, inputs: Mapping[str, str]) -> dict[str, Any]:
        """Return the inputs by groups, each with its name, default, what is allowed and meaning; and the profiles.

        Also the metric name of each input and the metric value of its unit, and the names and metric values of the
        other units that the page shows. `inputs` may choose the units.
        """
        system = inputs.get("units", self.units)
        groups: dict[str, list[tuple[Any, ...]]] = {caption: [] for caption in GROUPS.values()}
        for path, entry in shown_inputs(Wheelset):
            if path[0] == "contact" and path[-1] not in Spatial.model_fields:  # the page shows three dimensions
                continue
            unit = us_key(path[-1]) if system == "us" else None
            name = ".".join((*path[:-1], unit.name if unit else path[-1]))
            row = name, default_text(entry, unit), allowed(entry, unit), entry.description or "", ".".join(path)
            groups[GROUPS[path[0]]].append((*row, float(unit.metric) if unit else 1.0))
        units = {unit: us_unit(unit) for unit in ("mm", "MPa", "N") if system == "us"}
        names = {"wheel": [*WHEELS, *REFERENCE_WHEELS], "rail": [*SECTIONS, REFERENCE_RAIL]}
        return {
            "groups": [*groups.items()],
            "profiles": names,
            "files": list(self.files),
            "system": system,
            "units": {unit: (us_unit.name, float(us_unit.metric)) for unit, us_unit in units.items() if us_unit},
        }

    def add_profile(self, name: str, content: bytes, options: Mapping[str, Any]) -> dict[str, Any]:
        """Keep a dropped file, and return how it is read: kind, orientation, notices, and its points for a picture."""
        base = Path(name.replace("\\", "/")).name
        if Path(base).suffix.lower() not in READABLE or len(base) > MAX_NAME or not base.isprintable():
            raise InputError(
                f"the file {short(base)}", f"a profile: {', '.join(READABLE)}", "drop a file of one of these"
            )
        path = Path(tempfile.mkdtemp(dir=self.folder)) / base if content else self._path(base)
        if content:
            path.write_bytes(content)
        try:
            measured = read_profile(path, ReadOptions(**options))
        except InputError as reason:
            if content:
                shutil.rmtree(path.parent)
            given = reason.given.replace(f"{path.parent}{os.sep}", "")
            raise InputError(given, reason.allowed, reason.advice) from reason
        self.files[base] = path
        surface = measured.surface.sampled(max_deviation=OUTLINE_MM)
        return {
            "name": base,
            "kind": measured.kind,
            "title": measured.title,
            "format": measured.format,
            "notices": list(measured.notices),
            "measured": _rounded(measured.points),
            "surface": _rounded(surface),
        }

    def case(self, inputs: Mapping[str, str]) -> Wheelset:
        """Return the case of the inputs of the form, texts by path; files by the names that the page has for them."""
        given: dict[str, Any] = {key: text.strip() for key, text in inputs.items() if text.strip()}
        for key, text in given.items():
            if key.rpartition(".")[2] not in FILE_KEYS:
                given[key] = GivenText(text)
            elif Path(text).suffix.lower() in (*READABLE, *TABLES):
                given[key] = str(self._path(text))
            elif "/" in text or "\\" in text:
                raise InputError(f"{key} = {text}", "a bundled profile or a file of this page", "drop the file")
        units = given.pop("units", self.units)
        # a profile stands before the options of its file
        ordered = {key: given[key] for key in sorted(given, key=lambda key: key.count("."))}
        return Wheelset.from_values({"units": units, **with_settings(Wheelset, {}, ordered)})

    def geometry(self, inputs: Mapping[str, str]) -> dict[str, Any]:
        """Return outlines, and rigid contact over the lateral position: points, radii, angles, conicity."""
        case = self.case(inputs)
        content = case_content(case)
        key = hash_of([content["track"], content["wheelset"], case.position.yaw_mrad])
        return self._rigid.submit(self._geometries.get, key, lambda: _geometry(case)).result()

    def position(self, inputs: Mapping[str, str]) -> dict[str, Any]:
        """Return a position with its patches; `SupersededError` if a newer request comes meanwhile."""
        return self._alone(lambda progress: self._position(self._run(self.case(inputs), progress)))

    def _position(self, run: SpatialWheelsetRun) -> dict[str, Any]:
        result, table = run.result, results_table(run)
        return {
            "converged": result.status.converged,
            "message": result.status.message,
            "warnings": list(result.warnings),
            "facts": spatial_facts(run),
            "table": {"header": table.header, "rows": table.rows},
            "patches": _patches(run),
            "contacts": _contacts(run),
            "lateral_mm": result.equilibrium.position.lateral_mm,
            "max_pressure_MPa": max((patch.max_pressure for patch in result.patches), default=None),
            "t_gamma_N": sum(creep.t_gamma_N for _, creep in result.rolling) if result.rolling else None,
        }

    def report(self, inputs: Mapping[str, str]) -> str:
        """Return the report of a position, one page of HTML."""

        def page(progress: Progress) -> str:
            record = case_record(self._run(self.case(inputs), progress))
            return report_page(record, [(picture, png(picture.draw())) for picture in record.pictures()])

        return self._alone(page)

    def tables(self, inputs: Mapping[str, str]) -> dict[str, str]:
        """Return the CSV files of a position by their names, as ``flangeway run`` writes them."""

        def texts(progress: Progress) -> dict[str, str]:
            files = case_record(self._run(self.case(inputs), progress)).files()
            writers = {name: write for name, write in files.items() if name.endswith(".csv")}
            with tempfile.TemporaryDirectory(dir=self.folder) as folder:
                return {path.name: path.read_text("utf-8") for path in write_together(Path(folder), writers)}

        return self._alone(texts)

    def saved(self, inputs: Mapping[str, str]) -> dict[str, str]:
        """Return what computes the position again: a case file, a command, and a campaign over the lateral position."""
        case = self.case(inputs)
        at_all = {key: value for key, value in case.changed.items() if key != "units"}
        at_all.get("position", {}).pop("lateral_mm", None)
        campaign = toml_text({"case": case.name, "inputs": at_all}) + f"\n[vary]\n{LATERAL_POSITIONS}\n"
        texts = {"case": write_case_file(case), "command": command_line(case), "campaign": campaign}
        for name, path in self.files.items():  # beside the files of the user, by their names
            for given in (os.path.relpath(path), str(path)):
                texts = {what: text.replace(given, name) for what, text in texts.items()}
        return texts

    def cancel(self) -> None:
        """Stop what is computed."""
        self._newest += 1

    @property
    def computing(self) -> bool:
        """Whether a position or a report is being computed."""
        return self._computing.locked()

    def _alone(self, work: Callable[[Progress], T]) -> T:
        """Wait for the computation before, which stops at its next step; the work ends once a newer one is there."""
        self._newest += 1
        number = self._newest

        def progress(_: str) -> None:
            if number != self._newest:
                raise SupersededError("a newer position was asked for")

        with self._computing:
            progress("")
            return self._positions.submit(work, progress).result()

    def _run(self, case: Wheelset, progress: Progress) -> SpatialWheelsetRun:
        run: Any = case.run_on(self._bodies.get(bodies_key(case), lambda: case.prepared(progress)), progress)
        return run

    def _path(self, name: str) -> Path:
        try:
            return self.files[str(name)]
        except KeyError as reason:
            raise InputError(f"the file {name}", "files that were given to this page", "drop the file") from reason


def shown_inputs(record: type[Record], above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], FieldInfo]]:
    """Yield the inputs of the form with their paths: plain ones, and of tables of several kinds the kind as well.

    Of a table in place of a plain value, such as a file with its options, what it needs is left out: this is the value.
    """
    for key, entry in record.described_fields().items():
        kinds, is_table = records_in(entry.annotation), are_tables(entry.annotation)
        if key not in (TAG, *OF_REPORT) and not (is_table and len(kinds) == 1):
            yield (*above, key), entry
        seen: dict[tuple[str, ...], FieldInfo] = {}
        for kind in kinds:
            for path, inner in shown_inputs(kind, (*above, key)):
                if seen.setdefault(path, inner) is inner and (is_table or not inner.is_required()):
                    yield path, inner


def _geometry(case: Wheelset) -> dict[str, Any]:
    track, wheelset = case.track, case.wheels
    rigid = RigidGeometry.of(track, wheelset, case.position.yaw_rad)
    locus = rigid.scanned(LATERAL_MM, STEP_MM)
    lateral = np.round(locus.lateral_mm, 9)
    reach = min(-lateral[0], lateral[-1])
    amplitudes = AMPLITUDES_MM[reach > AMPLITUDES_MM]
    conicity = equivalent_conicity(RollingRadiusDifference.of(locus), amplitudes) if len(amplitudes) else amplitudes
    sides = {}
    for side in SIDES:
        at = locus.side(side)
        rail, wheel = track.rail_of(side), wheelset.wheel_of(side)
        sides[side] = {
            "rail": _rounded(track.placement(side).points(rail.outline.sampled(max_deviation=OUTLINE_MM))),
            "wheel": _rounded(wheelset.placement(side).points(wheel.outline.sampled(max_deviation=OUTLINE_MM))),
            "points": _rounded(at.points_mm[:, 0]),
            "angles": _rounded(np.degrees(at.contact_angles_rad[:, 0])),
            "radii": _rounded(at.rolling_radii_mm[:, 0]),
            "titles": {"rail": rail.title, "wheel": wheel.title},
        }
    return {
        "lateral": _rounded(lateral),
        "vertical": _rounded(locus.vertical_mm),
        "roll": locus.roll_rad.tolist(),
        "difference": _rounded(locus.rolling_radius_difference_mm),
        "conicity": [_rounded(amplitudes), np.asarray(conicity).tolist()],
        "axle_height": wheelset.tape_radius_mm,
        "sides": sides,
    }


def _patches(run: SpatialWheelsetRun) -> dict[str, Any]:
    """Cells under pressure of both sides from above as polygons, to the right and ahead in mm, with their values."""
    sides: dict[str, Any] = {}
    for side in SIDES:
        shown = patch_map(run.result, side)
        drawn, cells = shown.cells_drawn, shown.cells
        if not drawn.chosen.any():
            continue
        below = stresses_below(run.result, side)
        patches = [patch for patch in run.result.patches if patch.side == side]
        tractions = next((patch.tractions for patch in patches), None)
        sides[side] = {
            "polygons": _rounded(drawn.polygons),
            "outline": _rounded(drawn.outline),
            "pressures": _rounded(cells.pressures[drawn.chosen], 1),
            "stresses": {
                field.name: _rounded(below[field.array][drawn.chosen], 1) for field in below_fields(run.case.units)
            },
            # along the rail's surface to the right, and ahead
            "tractions": None
            if tractions is None
            else _rounded(tractions[drawn.chosen] * np.array([-SIDE_SIGN[side], 1.0]), 1),
            # cells of each patch, by its region
            "patches": [[patch.region, np.flatnonzero(patch.inside[drawn.chosen]).tolist()] for patch in patches],
        }
    return sides


def _contacts(run: SpatialWheelsetRun) -> list[tuple[str, list[Any], float, float]]:
    """Side, place (x, y) on the unloaded rail, contact angle in degrees and normal force in N of each patch."""
    placed = run.case.track.placement
    return [
        (
            patch.side,
            _rounded(placed(patch.side).points(patch.rail_point_mm[None])[0]),
            float(np.degrees(patch.contact_angle_rad)),
            patch.normal_force_N,
        )
        for patch in run.result.patches
    ]


def _rounded(values: Floats, digits: int = 4) -> list[Any]:
    """Lists of numbers with some decimals: a tenth of a micrometre is more than a picture shows."""
    return np.round(floats(values), digits).tolist()
