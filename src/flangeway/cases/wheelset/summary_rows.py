"""Rows of a run's summary that take a computation of their own: below the contacts, in the rails, at the supports."""

import math
from typing import Any

import numpy as np

from flangeway.exact.hertz_line_contact import DEPTH_OF_MAX_SHEAR
from flangeway.railway.rigid.rigid_contact import contact_locus
from flangeway.railway.rigid.rigid_equilibrium import RigidContactPoint, RigidPosition
from flangeway.railway.track.discretisation import Role
from flangeway.railway.track.placements import SIDES, Side, WheelsetMotion
from flangeway.railway.wheelset.bending import FaceStresses, RailBending, rail_bending
from flangeway.railway.wheelset.subsurface import SEARCHED, maximum_on, stresses_below
from flangeway.railway.wheelset.support_reactions import holding_force, support_reactions
from flangeway.railway.wheelset.wheelset_result import WheelRailPatch, WheelsetResult

Row = dict[str, Any]


def contact_row(result: WheelsetResult, patch: WheelRailPatch) -> Row:
    """Force, place, pressure and subsurface stresses of one region of contact."""
    lateral, vertical = patch.force_on_wheel_N / 1e3
    hertz = patch.hertz
    return {
        "side": patch.side,
        "region": patch.region,
        "force_kN": math.hypot(lateral, vertical),
        "lateral_force_kN": lateral,
        "vertical_force_kN": vertical,
        "contact_angle_deg": _angle(patch.side, lateral, vertical),
        "rail_position_mm": patch.rail_point_mm,
        "wheel_position_mm": patch.wheel_point_mm,
        "space_position_mm": patch.pressure.centre,
        "half_width_mm": patch.pressure.half_width,
        "max_pressure_MPa": patch.pressure.pressures.max(),
        "max_pressure_remark": patch.pressure.remark,
        "pressure_oscillation": patch.pressure.scatter,
        "hertz_half_width_mm": hertz.half_width if hertz else None,
        "hertz_pressure_MPa": hertz.max_pressure if hertz else None,
        "hertz_in_plane_shear_MPa": hertz.max_shear if hertz else None,
        "hertz_in_plane_shear_depth_mm": DEPTH_OF_MAX_SHEAR * hertz.half_width if hertz else None,
        "n_nodes": len(patch.pressure.normal_forces),
        "in_rail": _below(result, patch, "rail"),
        "in_wheel": _below(result, patch, "wheel"),
    }


def _angle(side: Side, lateral: float, vertical: float) -> float:
    """Angle in degrees of the tangent to which a force on the wheel is normal, positive towards the flange."""
    return math.degrees(math.atan2(-lateral if side == "right" else lateral, vertical))


def _below(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> Row:
    """Maximum stresses on the normal below the centre of pressure."""
    line = stresses_below(result, patch, body)
    shear = maximum_on(line.distances, line.stresses.in_plane_shear, SEARCHED)
    mises = maximum_on(line.distances, line.stresses.von_mises, SEARCHED)
    return {
        "max_in_plane_shear_MPa": shear.value_MPa,
        "max_in_plane_shear_depth_mm": shear.depth_mm,
        "max_von_mises_MPa": mises.value_MPa,
        "max_von_mises_depth_mm": mises.depth_mm,
    }


def bending_rows(result: WheelsetResult) -> list[Row]:
    """Bending of both rails."""
    return [_bending(rail_bending(result, side)) for side in SIDES]


def _bending(rail: RailBending) -> Row:
    motion = rail.head_motion
    outward = motion.roll_rad if rail.side == "left" else -motion.roll_rad
    return {
        "side": rail.side,
        "head_lateral_mm": motion.lateral_mm,
        "head_vertical_mm": motion.vertical_mm,
        "head_roll_rad": motion.roll_rad,
        "head_roll_outward_rad": outward,
        "gauge_outward_mm": rail.gauge_outward_mm,
        "web_height_mm": rail.web_height_mm,
        "web_thickness_mm": rail.web_thickness_mm,
        "web_normal_force_kN": rail.web_normal_N / 1e3,
        "web_shear_force_kN": rail.web_shear_N / 1e3,
        "web_moment_kN_mm": rail.web_moment_Nmm / 1e3,
        **{f"web_{face.face}_face_MPa": face.web_MPa for face in rail.faces},
        "fillets": [
            _fillet(face, place, *limits)
            for face in rail.faces
            for place, limits in (("head", (rail.web_height_mm, np.inf)), ("foot", (-np.inf, rail.web_height_mm)))
        ],
    }


def _fillet(face: FaceStresses, place: str, above_mm: float, below_mm: float) -> Row:
    """Extremes of the stress along the surface between the web's narrowest place and head or foot."""
    row: Row = {"face": face.face, "towards": place}
    for word, sign in (("tension", 1.0), ("compression", -1.0)):
        value, point = face.extreme(sign, above_mm, below_mm)
        # the other principal stress in the plane is zero: a surface in compression all along has no tension
        row[f"max_{word}_MPa"] = sign * max(sign * value, 0.0)
        row[f"{word}_position_mm"] = point
    return row


def support_rows(result: WheelsetResult) -> Row:
    """Reactions of bases and axle, their balance with the contact forces, and what holds a prescribed motion."""
    reactions = [
        {
            "part": each.part,
            "lateral_force_kN": each.force_N[0] / 1e3,
            "vertical_force_kN": each.force_N[1] / 1e3,
            "moment_kN_mm": each.moment_Nmm / 1e3,
            "reference_mm": each.reference_mm,
            **({"eccentricity_mm": each.eccentricity_mm} if each.part.startswith("rail") else {}),
            "force_error": each.force_error,
            "moment_residual": each.moment_residual,
        }
        for each in support_reactions(result)
    ]
    held = holding_force(result)
    holding = {}
    if held is not None:
        holding = {"lateral_N": held.lateral_N, "vertical_N": held.vertical_N, "moment_N_mm": held.moment_Nmm}
    return {"reactions": reactions, "holding": holding}


def rigid_rows(result: WheelsetResult) -> Row:
    """Position, contact points, forces and Hertz's estimates of rigid wheels on rigid rails.

    With a prescribed lateral motion there is no balance of the rigid wheelset, and no forces.
    """
    rest = result.model.rest
    position = None if rest.equilibrium is None else rest.equilibrium.position
    if position is None:
        motion, points = rest.motion, _touching(result)
    else:
        motion, points = position.motion, list(position.contacts)
    problem = result.model.problem
    lateral, vertical = problem.load.to_space(motion.lateral_mm, motion.vertical_mm)
    return {
        "vertical_mm": motion.vertical_mm,
        "lateral_mm": motion.lateral_mm,
        "roll_rad": motion.roll_rad,
        "horizontal_in_space_mm": lateral,
        "vertical_in_space_mm": vertical,
        "contacts": [_rigid_contact(result, point, position) for point in points],
    }


def _touching(result: WheelsetResult) -> list[RigidContactPoint]:
    """Points of contact at the prescribed lateral motion, without force."""
    rest = result.model.rest
    locus = contact_locus(rest.wheelset, [rest.motion.lateral_mm])
    points = []
    for side in SIDES:
        at = locus.side(side)
        on_wheel, on_rail, place = (
            (float(row[0, 0, 0]), float(row[0, 0, 1])) for row in (at.wheel_points_mm, at.rail_points_mm, at.points_mm)
        )
        angle, radius, curvature = (
            float(row[0, 0]) for row in (at.contact_angles_rad, at.rolling_radii_mm, at.relative_curvatures_per_mm)
        )
        points.append(RigidContactPoint(side, on_wheel, on_rail, place, angle, radius, curvature, 0.0))
    return points


def _rigid_contact(result: WheelsetResult, point: RigidContactPoint, position: RigidPosition | None) -> Row:
    hertz = None
    if point.normal_force_N > 0.0:
        hertz = result.model.hertz_at(point.side, point.wheel_point_mm, point.rail_point_mm, point.normal_force_N)
    lateral, vertical = (force / 1e3 for force in point.force_on_wheel_N)
    return {
        "side": point.side,
        "force_kN": point.normal_force_N / 1e3 if position else None,
        "lateral_force_kN": lateral if position else None,
        "vertical_force_kN": vertical if position else None,
        "contact_angle_deg": math.degrees(point.contact_angle_rad),
        "rail_position_mm": point.rail_point_mm,
        "wheel_position_mm": point.wheel_point_mm,
        "space_position_mm": point.point_mm,
        "rolling_radius_mm": point.rolling_radius_mm,
        "hertz_half_width_mm": hertz.half_width if hertz else None,
        "hertz_pressure_MPa": hertz.max_pressure if hertz else None,
    }


def other_rows(result: WheelsetResult) -> list[Row]:
    """Further balances, if several were found."""
    return [
        {
            **motion_row(each.motion),
            "stable": each.stable,
            "equilibrium_residual": each.balance.equilibrium_residual,
        }
        for each in result.others
    ]


def motion_row(motion: WheelsetMotion) -> Row:
    """Components of a motion."""
    return {"vertical_mm": motion.vertical_mm, "lateral_mm": motion.lateral_mm, "roll_rad": motion.roll_rad}
