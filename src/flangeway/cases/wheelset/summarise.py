"""From the result of a wheelset to its summary."""

import math
from dataclasses import replace

from flangeway.cases.wheelset.wheelset_inputs import WheelsetInputs
from flangeway.cases.wheelset.wheelset_profiles import profile_notes, side_warnings
from flangeway.cases.wheelset.wheelset_summary import (
    ContactSummary,
    MeshSummary,
    RigidContactSummary,
    RigidSummary,
    StressSummary,
    SubsurfaceSummary,
    WheelsetSummary,
    equilibrium_parts,
)
from flangeway.exact.hertz_line_contact import DEPTH_OF_MAX_SHEAR
from flangeway.post import cell_stresses
from flangeway.railway.rigid.rigid_equilibrium import RigidContactPoint, RigidPosition, contact_points
from flangeway.railway.track.discretisation import Role
from flangeway.railway.wheelset.subsurface import SEARCHED, maximum_on, stresses_below
from flangeway.railway.wheelset.wheelset_checks import SLICE, below_contacts
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult

CONFORMING = (
    "Hertz's theory is left out where wheel and rail conform: where its half width is above half of a radius of either "
    "profile, or the gap of the profiles at an end of it is 1.5 times that of constant curvature, or less than 1 / 1.5."
)


def summarise(case: WheelsetInputs, result: WheelsetResult, total_s: float) -> WheelsetSummary:
    """Return the summary of a solved case.

    Parameters
    ----------
    total_s
        Wall-clock time of the computation in seconds.

    """
    timings = {name.replace("-", "_"): seconds for name, seconds in result.timings_s.items()}
    return WheelsetSummary(
        **equilibrium_parts(result, result.model.problem.load),
        contacts=[_contact(result, patch) for patch in result.patches],
        rigid=_rigid(result),
        stresses=_stresses(result),
        bodies=_bodies(result),
        timings_s=timings | {"total": total_s},
        case={"name": case.name, **case.model_dump()},
        assumptions=_assumptions(case, result),
        published=case.published_position(),
        warnings=[*result.warnings, *side_warnings(result.model.problem.track)],
    )


def _contact(result: WheelsetResult, patch: WheelRailPatch) -> ContactSummary:
    lateral, vertical = patch.force_on_wheel_N / 1e3
    hertz, pressure = patch.hertz, patch.pressure
    inward = -lateral if patch.side == "right" else lateral
    return ContactSummary(
        side=patch.side,
        region=patch.region,
        force_kN=math.hypot(lateral, vertical),
        lateral_force_kN=lateral,
        vertical_force_kN=vertical,
        # of the tangent to which the force is normal, positive towards the flange
        contact_angle_deg=math.degrees(math.atan2(inward, vertical)),
        rail_position_mm=patch.rail_point_mm.tolist(),
        wheel_position_mm=patch.wheel_point_mm.tolist(),
        space_position_mm=pressure.centre.tolist(),
        half_width_mm=pressure.half_width,
        max_pressure_MPa=pressure.pressures.max(),
        max_pressure_remark=pressure.remark,
        pressure_oscillation=pressure.oscillation,
        hertz_half_width_mm=hertz.half_width if hertz else None,
        hertz_pressure_MPa=hertz.max_pressure if hertz else None,
        hertz_in_plane_shear_MPa=hertz.max_shear if hertz else None,
        hertz_in_plane_shear_depth_mm=DEPTH_OF_MAX_SHEAR * hertz.half_width if hertz else None,
        n_nodes=len(pressure.normal_forces),
        in_rail=_below(result, patch, "rail"),
        in_wheel=_below(result, patch, "wheel"),
    )


def _below(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> SubsurfaceSummary:
    line = stresses_below(result, patch, body)
    shear = maximum_on(line.distances, line.stresses.in_plane_shear, SEARCHED)
    mises = maximum_on(line.distances, line.stresses.von_mises, SEARCHED)
    return SubsurfaceSummary(shear.value_MPa, shear.depth_mm, mises.value_MPa, mises.depth_mm)


def _rigid(result: WheelsetResult) -> RigidSummary:
    """Rigid wheels on rigid rails; with a prescribed lateral position there is no equilibrium, and no forces."""
    start = result.model.rigid_start
    position = None if start.equilibrium is None else start.equilibrium.position
    if position is None:
        motion, touching = start.motion, start.geometry.locus([start.motion.lateral_mm])
        points = [replace(point, normal_force_N=0.0) for point in contact_points(touching, range(1))]
    else:
        motion, points = position.motion, list(position.contacts)
    in_space = motion.turned(result.model.problem.load.tilt_rad)
    return RigidSummary(
        *(motion.vertical_mm, motion.lateral_mm, motion.roll_rad, in_space.lateral_mm, in_space.vertical_mm),
        [_rigid_contact(result, point, position) for point in points],
    )


def _rigid_contact(
    result: WheelsetResult, point: RigidContactPoint, position: RigidPosition | None
) -> RigidContactSummary:
    hertz = None
    if point.normal_force_N > 0.0:
        hertz = result.model.hertz_at(point.side, point.wheel_point_mm, point.rail_point_mm, point.normal_force_N)
    lateral, vertical = (force / 1e3 for force in point.force_on_wheel_N)
    return RigidContactSummary(
        side=point.side,
        force_kN=point.normal_force_N / 1e3 if position else None,
        lateral_force_kN=lateral if position else None,
        vertical_force_kN=vertical if position else None,
        contact_angle_deg=math.degrees(point.contact_angle_rad),
        rail_position_mm=point.rail_point_mm,
        wheel_position_mm=point.wheel_point_mm,
        space_position_mm=point.point_mm,
        hertz_half_width_mm=hertz.half_width if hertz else None,
        hertz_pressure_MPa=hertz.max_pressure if hertz else None,
        rolling_radius_mm=point.rolling_radius_mm,
    )


def _stresses(result: WheelsetResult) -> list[StressSummary]:
    rows = []
    for name, displacement in sorted(result.displacements.items()):
        stresses = cell_stresses(result.model.parts[name].body.elasticity, displacement)
        near = stresses.von_mises[below_contacts(result.model, result.patches, name)]
        rows.append(
            StressSummary(
                *(name, near.max() if len(near) else None, stresses.von_mises.max()),
                *(stresses.principal[:, 2].min(), stresses.in_plane_shear.max()),
            )
        )
    return rows


def _bodies(result: WheelsetResult) -> list[MeshSummary]:
    parts = result.model.parts.items()
    return [
        MeshSummary(
            *(body.name, body.stiffness.n, body.space.mesh.n_cells, body.space.n_nodes),
            sorted(name for name, part in parts if part.body is body),
        )
        for body in result.model.bodies
    ]


def _assumptions(case: WheelsetInputs, result: WheelsetResult) -> list[str]:
    problem = result.model.problem
    wheelset, track = problem.wheelset, problem.track
    role, reason = problem.primary
    materials = {"wheels": problem.material_of("wheel"), "rails": problem.material_of("rail")}
    if materials["wheels"] == materials["rails"]:
        materials = {"steel": problem.material}
    return [
        "Plane strain: the bodies do not stretch in the direction of the track.",
        SLICE.format(case.thickness_mm),
        f"Thickness {case.thickness_mm:g} mm: this length of wheel and rail carries the whole load.",
        *case.derived(),
        *profile_notes(track, wheelset),
        *(
            f"Linear elastic, isotropic {name}: Young's modulus {each.young:g} MPa, Poisson's ratio "
            f"{each.poisson:g}; no yielding, however high the stress."
            for name, each in materials.items()
        ),
        "Contact without friction.",
        *([CONFORMING] if any(patch.hertz is None for patch in result.patches) else []),
        f"The {role}s are the primary surface: {reason}.",
        "The rails are fixed along their whole base.",
        "The wheels' cuts and the axle are rigid; the load acts at the car's centre of gravity and stays vertical"
        + (", its lateral force horizontal." if problem.load.lateral_N else "."),
        *(
            ["The left side is the mirror image of the right side, mesh included."]
            if wheelset.is_symmetric and track.is_symmetric
            else []
        ),
    ]
