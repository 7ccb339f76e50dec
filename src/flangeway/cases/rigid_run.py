"""Contact geometry and conicity of a rigid wheelset on rigid rails: inputs and results of ``flangeway geometry``."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import annotated_types as at
import numpy as np

from flangeway.cases.case import Case
from flangeway.cases.case_file import CaseText, resolved
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.cases.wheelset.wheelset_notes import derived, side_warnings
from flangeway.cases.wheelset.wheelset_quantities import TRACK
from flangeway.errors import InputError, short
from flangeway.exact import LineContact, contact_modulus
from flangeway.quantities import Quantities, Quantity, values
from flangeway.railway.profiles.orientation import conforming
from flangeway.railway.rigid.conicity import (
    REFERENCE_AMPLITUDE_MM,
    RollingRadiusDifference,
    conicity_by_regression,
    equivalent_conicity,
    motion_middles,
    read_rolling_radius_difference,
)
from flangeway.railway.rigid.rigid_equilibrium import (
    RigidContactPoint,
    RigidEquilibrium,
    RigidPosition,
    rigid_equilibrium,
)
from flangeway.railway.rigid.rigid_geometry import ContactJump, ContactLocus, RigidGeometry
from flangeway.railway.rigid.rigid_side import MAX_YAW_RAD
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_problem import Plane, WheelsetOnTrack
from flangeway.railway.wheelset.spatial_result import BESIDE_MM
from flangeway.records import (
    TAG,
    LengthUnit,
    Positive,
    Record,
    closest,
    key_text,
    kind_of,
    leaves,
    path_by_ending,
    records_in,
    with_settings,
)
from flangeway.results import Result, ResultTable
from flangeway.system.file_content import toml_data
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.output_folder import versions
from flangeway.types import Floats, Progress

# --- Inputs of ``flangeway geometry``: a rigid wheelset on two rigid rails, its profiles, measures and load.


class Scan(Record):
    """Positions of the rigid wheelset, and amplitudes of its conicity."""

    maximum_lateral_mm: Annotated[float, at.Gt(0.0), at.Le(60.0)] = 8.0
    """maximum lateral displacement that is shown; less where a flange climbs before"""
    step_mm: Annotated[float, at.Ge(1e-3), at.Le(1.0)] = 0.02
    """distance of the positions"""
    maximum_amplitude_mm: Annotated[float, at.Gt(0.0), at.Le(30.0)] = 6.0
    """maximum amplitude of the conicity"""
    roll: Literal["free", "none"] = "free"
    """free: both wheels touch; none: no roll, as in the reference results of EN 15302"""


class Yaw(Record):
    """The position of the rigid wheelset as far as it is prescribed."""

    yaw_mrad: Annotated[float, at.Ge(-1e3 * MAX_YAW_RAD), at.Le(1e3 * MAX_YAW_RAD)] = 0.0
    """yaw of the axle, counter-clockwise seen from above: the right wheel is ahead"""


class Slice(Record):
    """What Hertz's estimates are for."""

    thickness_mm: Positive = Plane.model_fields["thickness_mm"].default
    """length of the bodies along the track, for Hertz's estimate"""


class GeometryCase(WheelsetOnTrack, Case):
    """A rigid wheelset on two rigid rails; material and thickness are for Hertz's estimate."""

    name = "geometry"
    title = "Contact geometry of a rigid wheelset on rigid rails"

    position: Yaw = Yaw()
    """yaw of the axle"""
    scan: Scan = Scan()
    """positions and amplitudes"""
    contact: Slice = Slice()
    """what Hertz's estimates are for"""

    def geometry(self) -> RigidGeometry:
        """Return the rigid geometry; an `InputError` if a profile is unknown or a length is not allowed."""
        return RigidGeometry.of(self.track, self.wheels, 1e-3 * self.position.yaw_mrad)


_FILE = Path(__file__).with_name("geometry_cases.toml")
GEOMETRY_CASES: dict[str, tuple[str, dict[str, Any]]] = {
    name: (inputs.pop("title"), inputs) for name, inputs in toml_data(_FILE.read_text(encoding="utf-8"), "").items()
}
"""Title and inputs that differ from the defaults, by name."""


def find_geometry_case(name: str, settings: Mapping[str, Any]) -> GeometryCase:
    """Return a case by its name with some inputs changed, see `flangeway.records.with_settings`.

    It is an `InputError` if there is none of that name, or an input is wrong.
    """
    if name not in GEOMETRY_CASES:
        raise InputError(
            f"a geometry case called {name!r}",
            f"one of: {', '.join(GEOMETRY_CASES)}; a case file; or a file of a rolling radius difference",
            closest(name, list(GEOMETRY_CASES)),
        )
    return GeometryCase.from_values(with_settings(GeometryCase, GEOMETRY_CASES[name][1], settings))


def read_geometry_case(file: Path, settings: Mapping[str, Any]) -> tuple[GeometryCase, tuple[str, ...]]:
    """Return the geometry case of a case file, and a sentence on the inputs that it does not use.

    It is an `InputError` if the file is of another case, or an input is wrong; the message names file, line and key.
    - `file`: a case file of a wheelset, as `flangeway.cases.case_file.read_case` reads it, or with ``case =
      "geometry"``.
    - `settings`: inputs that replace those of the file, see `flangeway.records.with_settings`.
    """
    text = CaseText.read(file)
    name, values = text.name_and_values()
    if name not in (GeometryCase.name, Wheelset.name):
        raise InputError(
            f"{text.place(('case',))}case = {short(name)}",
            f"a wheelset: {Wheelset.name} or {GeometryCase.name}",
            "`flangeway run` computes the other cases",
        )
    unused = list[str]()
    used = resolved(text, _used(values, GeometryCase, Wheelset, "", unused), file.parent)
    replaced = {path_by_ending(GeometryCase, key)[0] for key in settings}
    case = GeometryCase.from_values(
        with_settings(GeometryCase, used, settings), lambda key: "" if key and key[0] in replaced else text.place(key)
    )
    return case, (f"not used by the geometry: {', '.join(unused)}",) if unused else ()


def _used(
    values: Mapping[str, Any], record: type[Record], of_wheelset: type[Record], above: str, unused: list[str]
) -> dict[str, Any]:
    """Inputs of a wheelset that its rigid geometry has; the paths of the others are added to a list."""
    used = {}
    for key, value in values.items():
        name, path = of_wheelset.input_named(key)[0], f"{above}{key}"
        own, other = (
            records_in(kind.model_fields[name].annotation) if name in kind.model_fields else []
            for kind in (record, of_wheelset)
        )
        if name in of_wheelset.model_fields and name not in record.model_fields:
            unused.append(path)
        elif own and other and own != other and isinstance(value, Mapping):
            # a kind of contact is chosen by its own keys
            wide = next((kind for kind in other if kind_of(kind) == value.get(TAG)), other[0])
            used[key] = _used(value, own[0], wide, f"{path}.", unused)
        elif own != other and not isinstance(value, Mapping):
            unused.append(path)
        else:
            used[key] = value
    return used


# --- Contact geometry and conicity of a rigid wheelset on rigid rails, as ``flangeway geometry`` computes them.


STEP_MM = 0.1
FIRST_MM = 0.5


@dataclass(frozen=True, eq=False)
class Conicities(Result):
    """Equivalent conicity over the amplitude."""

    amplitudes_mm: Floats
    integration: Floats
    regression: Floats
    """amplitudes_mm, integration, regression: amplitudes, and conicity by integration and by linear regression, (n,);
    empty if the wheelset does not steer."""
    notices: tuple[str, ...]  # sentences on amplitudes without a conicity

    @property
    def table(self) -> ResultTable:
        """Conicity over the amplitude."""
        columns = (self.amplitudes_mm, self.integration, self.regression)
        return ResultTable(
            dict(zip(("amplitude_mm", "conicity_integration", "conicity_regression"), columns, strict=True))
        )

    @property
    def at_reference(self) -> dict[str, float] | None:
        """Conicity at the reference amplitude; None where it is not computed."""
        at = np.flatnonzero(np.abs(self.amplitudes_mm - REFERENCE_AMPLITUDE_MM) < 1e-6)
        if not len(at):
            return None
        numbers = (float(column[at[0]]) for column in (self.amplitudes_mm, self.integration, self.regression))
        return dict(zip(("amplitude_mm", "integration", "regression"), numbers, strict=True))


def conicities_of(difference: RollingRadiusDifference, maximum_mm: float | None) -> Conicities:
    """Conicity at amplitudes 0.1 mm apart, as far as the difference is given.

    - `maximum_mm`: maximum amplitude; None: as far as the difference goes.
    """
    none: Floats = np.zeros(0)
    try:
        middle = difference.centred_mm
    except InputError as error:
        return Conicities(none, none, none, ("no equivalent conicity: " + error.given,))
    room = min(middle - float(difference.lateral_mm[0]), float(difference.lateral_mm[-1]) - middle)
    maximum = room if maximum_mm is None else min(maximum_mm, room)
    amplitudes = np.arange(round(FIRST_MM / STEP_MM), math.floor(maximum / STEP_MM + 1e-9) + 1.0) * STEP_MM
    outside = np.isnan(motion_middles(difference, amplitudes))
    amplitudes = amplitudes[: np.argmax(outside)] if outside.any() else amplitudes
    notices = []
    reached = float(amplitudes[-1]) if len(amplitudes) else 0.0
    if maximum_mm is not None and reached < math.floor(maximum_mm / STEP_MM + 1e-9) * STEP_MM - 1e-6:
        notices.append(f"conicity only up to an amplitude of {reached:.1f} mm")
    integration = equivalent_conicity(difference, amplitudes) if len(amplitudes) else none
    pushed = amplitudes[np.isnan(integration)]
    if len(pushed):
        notices.append(
            f"no equivalent conicity by integration at {len(pushed)} amplitudes from {pushed[0]:.1f} to "
            f"{pushed[-1]:.1f} mm: the rolling radius difference pushes the wheelset away from the middle"
        )
    regression = conicity_by_regression(difference, amplitudes) if len(amplitudes) else none
    return Conicities(amplitudes, integration, regression, tuple(notices))


@dataclass(frozen=True, eq=False)
class ConicityRun(Result):
    """Equivalent conicity from a file."""

    difference: RollingRadiusDifference  # content of the file
    conicities: Conicities  # conicity over the amplitude
    summary: dict[str, Any]  # content of ``geometry.json``

    @property
    def table(self) -> ResultTable:
        """Conicity over the amplitude."""
        return self.conicities.table


class ConicityCase(Case):
    """Inputs for the conicity of a rolling radius difference."""

    name = "conicity"
    title = "Equivalent conicity of a rolling radius difference"

    unit: LengthUnit | None = None
    """unit of both columns; that of the file if left out"""
    maximum_amplitude_mm: Annotated[float, at.Ge(FIRST_MM), at.Le(30.0)] | None = None
    """maximum amplitude; as far as the difference is given if left out"""


def run_conicity(file: Path, inputs: Mapping[str, Any]) -> ConicityRun:
    """Read a rolling radius difference and compute its conicity.

    It is an `InputError` if the file cannot be read as a rolling radius difference, or an input is wrong.
    - `file`: see `flangeway.railway.rigid.conicity.read_rolling_radius_difference`.
    - `inputs`: inputs of a `ConicityCase`.
    """
    start = time.perf_counter()
    case = ConicityCase.from_values(inputs)
    difference = read_rolling_radius_difference(file, case.unit)
    conicities = conicities_of(difference, case.maximum_amplitude_mm)
    summary = {
        "case": file.stem,
        "title": f"Equivalent conicity of the rolling radius difference in {file.name}",
        "inputs": {"file": str(file), **case.model_dump()},
        "lateral_without_difference_mm": difference.centred_mm if len(conicities.amplitudes_mm) else None,
        "equivalent_conicity": conicities.at_reference,
        "notices": list(conicities.notices),
        "versions": versions(),
        "timings_s": {"total": time.perf_counter() - start},
    }
    return ConicityRun(difference, conicities, summary)


_FURTHER_MM = 4.0  # beyond the maximum amplitude: an asymmetric wheelset oscillates about another position


class LoadedContact(NamedTuple):
    """A point of contact in equilibrium, and Hertz's line contact there; None between conforming curves."""

    point: RigidContactPoint
    hertz: LineContact | None


CONTACT_QUANTITIES: Quantities[LoadedContact] = (
    Quantity("side", "side", lambda at: at.point.side),
    Quantity("normal_force", "normal force", lambda at: at.point.normal_force_N, "kN", ".2f", factor=1e-3),
    Quantity("contact_angle", "contact angle", lambda at: math.degrees(at.point.contact_angle_rad), "deg", ".2f"),
    Quantity("wheel_point", "point of the wheel", lambda at: at.point.wheel_point_mm, "mm", ".2f", ("x", "y")),
    Quantity("rail_point", "point of the rail", lambda at: at.point.rail_point_mm, "mm", ".2f", ("x", "y")),
    Quantity("rolling_radius", "rolling radius", lambda at: at.point.rolling_radius_mm, "mm", ".2f"),
    Quantity("ahead_of_axle", "longitudinal position of contact", lambda at: at.point.ahead_mm, "mm", ".2f"),
    Quantity("relative_curvature", "relative curvature", lambda at: at.point.relative_curvature_per_mm, "1/mm"),
    Quantity("hertz_half_width", "Hertz: half width", lambda at: at.hertz and at.hertz.half_width, "mm"),
    Quantity("hertz_max_pressure", "Hertz: maximum pressure", lambda at: at.hertz and at.hertz.max_pressure, "MPa"),
)
"""Numbers of a point of contact."""
POSITION_QUANTITIES: Quantities[RigidPosition] = (
    Quantity("lateral", "lateral position", lambda at: at.motion_in_space.lateral_mm, "mm", ".3f"),
    Quantity("vertical", "vertical position", lambda at: at.motion_in_space.vertical_mm, "mm", ".4f"),
    Quantity("roll", "roll", lambda at: at.motion_in_space.roll_rad, "mrad", ".4f", factor=1e3),
    Quantity(
        "lateral_over_vertical",
        "L/V",
        lambda at: [at.lateral_over_vertical(side) for side in SIDES],
        form=".3f",
        parts=SIDES,
    ),
)
"""Numbers of a position in equilibrium."""
CONICITY_QUANTITIES: Quantities["GeometryRun | ConicityRun"] = (
    Quantity(
        "conicity_integration",
        f"equivalent conicity at {REFERENCE_AMPLITUDE_MM:g} mm",
        lambda run: (run.conicities.at_reference or {}).get("integration"),
        form=".4f",
    ),
    Quantity(
        "conicity_regression",
        "  by linear regression",
        lambda run: (run.conicities.at_reference or {}).get("regression"),
        form=".4f",
    ),
)
"""Numbers of a rolling radius difference."""


@dataclass(frozen=True, eq=False)
class GeometryRun(Result):
    """Contact geometry of a case."""

    name: str
    case: GeometryCase  # name, case: name to show, and inputs
    geometry: RigidGeometry  # rigid geometry of the pair
    locus: ContactLocus  # points of contact over the lateral displacement
    jumps: tuple[ContactJump, ...]  # where they jump
    conicities: Conicities  # equivalent conicity over the amplitude
    equilibrium: RigidEquilibrium  # equilibria under the load
    contacts: tuple[LoadedContact, ...]  # points of contact in equilibrium
    summary: dict[str, Any]  # content of ``geometry.json``

    @property
    def table(self) -> ResultTable:
        """Positions and their points of contact, a row a position."""
        locus = self.locus
        columns = {
            "lateral_mm": locus.lateral_mm,
            "vertical_mm": locus.vertical_mm,
            "roll_mrad": 1e3 * locus.roll_rad,
            "rolling_radius_difference_mm": locus.rolling_radius_difference_mm,
        }
        for side in SIDES:
            at = locus.side(side)
            columns |= {
                f"{side}_wheel_x_mm": at.wheel_points_mm[:, 0, 0],
                f"{side}_rail_x_mm": at.rail_points_mm[:, 0, 0],
                f"{side}_contact_angle_deg": np.degrees(at.contact_angles_rad[:, 0]),
                f"{side}_rolling_radius_mm": at.rolling_radii_mm[:, 0],
                f"{side}_ahead_mm": at.ahead_mm[:, 0],
                f"{side}_next_gap_mm": at.gaps_mm[:, 1],
            }
        return ResultTable(columns)


def run_geometry(
    name: str, case: GeometryCase, progress: Progress = lambda _: None, notices: Sequence[str] = ()
) -> GeometryRun:
    """Compute the contact geometry of a case.

    It is an `InputError` if gauge and wheels do not fit.
    - `notices`: sentences about the inputs, to be shown with those about the results.
    """
    start = time.perf_counter()
    geometry, scan = case.geometry(), case.scan
    remarks = list(notices)
    progress("finding contact points")
    reach = max(scan.maximum_lateral_mm, scan.maximum_amplitude_mm + _FURTHER_MM)
    whole = geometry.scanned(reach, scan.step_mm, roll=scan.roll == "free")
    wanted = math.floor(scan.maximum_lateral_mm / scan.step_mm + 1e-9) * scan.step_mm
    shown = np.abs(whole.lateral_mm) < wanted + 0.5 * scan.step_mm
    first, last = np.flatnonzero(shown)[[0, -1]]
    locus = whole.part(slice(first, last + 1))
    if min(-locus.lateral_mm[0], locus.lateral_mm[-1]) < wanted - 0.5 * scan.step_mm:
        ends = map(geometry.path_end, SIDES if scan.roll == "free" else ())
        remarks.append(
            f"the scan of {scan.maximum_lateral_mm:g} mm stops at lateral displacements of "
            f"{locus.lateral_mm[0]:.2f} and {locus.lateral_mm[-1]:.2f} mm: beyond, "
            f"{'; '.join(dict.fromkeys(ends)) or 'a running surface ends'}"
        )
    progress("locating contact jumps")
    jumps = geometry.jumps(float(np.abs(locus.lateral_mm).max())) if scan.roll == "free" else ()
    progress("integrating the kinematic motion")
    conicities = conicities_of(RollingRadiusDifference.of(whole), scan.maximum_amplitude_mm)
    remarks += conicities.notices
    progress("finding the equilibrium under the load")
    equilibrium = rigid_equilibrium(geometry, case.forces)
    contacts = _loaded_contacts(equilibrium, case)
    remarks += _of_mirror_image(equilibrium, case)
    remarks += [*side_warnings(case.track), *derived(case)]
    status, position = equilibrium.status, equilibrium.position
    summary = {
        "case": name,
        "title": _title(name, case),
        "status": {"converged": status.converged, "message": status.message},
        "inputs": case.model_dump(),
        "track": values(TRACK, case.track),
        "load_lateral_over_vertical": equilibrium.load_ratio,
        "equilibrium": position
        and {
            **values(POSITION_QUANTITIES, position),
            "contacts": [values(CONTACT_QUANTITIES, contact) for contact in contacts],
        },
        "all_equilibria": [
            {
                "lateral_mm": other.motion_in_space.lateral_mm,
                "stable": other.stable,
                "neutral_between_mm": other.neutral_mm,
            }
            for other in equilibrium.positions
        ],
        "jumps": [
            {
                "side": jump.side,
                "lateral_mm": jump.motion.lateral_mm,
                "wheel_points_mm": jump.wheel_points_mm,
                "rail_points_mm": jump.rail_points_mm,
            }
            for jump in jumps
        ],
        "equivalent_conicity": conicities.at_reference,
        "notices": remarks,
        "versions": versions(),
        "timings_s": {"total": time.perf_counter() - start},
        "peak_memory_MB": peak_memory_bytes() / 1e6,
    }
    return GeometryRun(name, case, geometry, locus, jumps, conicities, equilibrium, contacts, summary)


def _of_mirror_image(equilibrium: RigidEquilibrium, case: GeometryCase) -> list[str]:
    """Say of a wheelset that stands beside the middle, though both sides are alike, where else it is in equilibrium."""
    position = equilibrium.position
    alike = case.has_alike_sides and case.forces.is_symmetric and not case.position.yaw_mrad
    if position is None or not alike or abs(position.motion.lateral_mm) < BESIDE_MM:
        return []
    others = (other for other in equilibrium.positions if other is not position)
    texts = (
        f"{other.motion.lateral_mm + 0.0:.2f} mm ({'stable' if other.stable else 'not stable'})" for other in others
    )
    return ["the wheelset stands beside the middle, though both sides are alike: " + ", ".join(texts)]


def _loaded_contacts(equilibrium: RigidEquilibrium, case: GeometryCase) -> tuple[LoadedContact, ...]:
    """Points of contact with Hertz's estimates where the bodies do not conform, see `conforming`."""
    steel = case.material.elastic.plane_modulus
    modulus = contact_modulus(steel, steel)
    contacts = []
    for point in equilibrium.position.contacts if equilibrium.position else ():
        hertz = point.hertz(case.contact.thickness_mm, modulus)
        wheel, rail = case.wheels.wheel_of(point.side), case.track.rail_of(point.side)
        bodies = wheel, point.wheel_point_mm, rail, point.rail_point_mm
        conforms = hertz is not None and conforming(*bodies, hertz.half_width)
        contacts.append(LoadedContact(point, None if conforms else hertz))
    return tuple(contacts)


def _title(name: str, case: GeometryCase) -> str:
    """Return the title of a case with the inputs that are changed."""
    if name not in GEOMETRY_CASES:
        return name
    title, changes = GEOMETRY_CASES[name]
    usual = dict(leaves(GeometryCase.from_values(changes).model_dump()))
    values = leaves(case.model_dump(exclude={"units"}))
    changed = [f"{key_text(key)} = {value}" for key, value in values if value != usual.get(key)]
    return title + "; changed: " + ", ".join(changed) if changed else title
