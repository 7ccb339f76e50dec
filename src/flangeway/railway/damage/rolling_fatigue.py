"""Rolling contact fatigue of a patch: surface fatigue index, T-gamma damage, shakedown index, Dang Van below it.

Sources: Ekberg, Kabo and Andersson (2002, Fatigue Fract. Eng. Mater. Struct. 25, 899-909) for the surface fatigue
index; Burstow (2004, RSSB report T115, Whole Life Rail Model) for T-gamma damage, its three points quoted from
memory; Dang Van (1993, ASTM STP 1191) for fatigue below the surface. The shakedown limits are those of
`flangeway.exact.shakedown`.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import are_finite, as_numbers, check_finite, check_positive
from flangeway.errors import InputError
from flangeway.exact.shakedown import shakedown_limits
from flangeway.records import NotNegative, Positive, Record
from flangeway.types import Floats

WLRM_T_GAMMA_N = (15.0, 65.0, 175.0)
"""T-gamma at which damage begins, is greatest, and is worn off as fast as it grows."""
WLRM_MAX_DAMAGE = 10e-6
"""Greatest damage of one axle: cracks are visible at a sum of 1, after 100,000 axles (R220, R260)."""
BALL_TOLERANCE = 1e-6
"""Relative error of the squared radius of the smallest ball about a stress history."""
MAX_BALL_STEPS = 20_000


def surface_fatigue_index(
    utilised_friction: float, semi_axes: tuple[float, float], force: float, k_MPa: float
) -> float:
    """FI_surf: surface fatigue is expected above 0 (Ekberg, Kabo and Andersson, 2002, equation 2).

    On Hertz's ellipse ``FI = mu - 2 pi a b k / (3 N)`` is ``mu - k / p0``: the distance from the line
    ``p0 / k = 1 / mu`` of the shakedown map.

    Parameters
    ----------
    utilised_friction
        Tangential over normal force.
    semi_axes
        Of the patch, mm.
    force
        Normal force, N.
    k_MPa
        Yield strength in shear.

    Raises
    ------
    InputError
        If a length, the force or k is not positive.

    """
    check_finite("surface_fatigue_index", "utilised_friction", utilised_friction)
    if not are_finite(semi_axes, 2):
        raise InputError(f"surface_fatigue_index(semi_axes={semi_axes})", "two lengths in mm", "give both")
    for name, value in (("semi_axes", semi_axes[0]), ("semi_axes", semi_axes[1]), ("force", force), ("k_MPa", k_MPa)):
        check_positive("surface_fatigue_index", name, value)
    return float(utilised_friction - 2.0 * np.pi * semi_axes[0] * semi_axes[1] * k_MPa / (3.0 * force))


@dataclass(frozen=True, eq=False)
class TGammaDamage:
    """Damage of one axle by the Whole Life Rail Model; arrays of the shape of T-gamma.

    - `cracks`: growth, >= 0.
    - `wear`: what wear takes off it, >= 0.
    """

    cracks: Floats
    wear: Floats

    @property
    def net(self) -> Floats:
        """Growth less wear: below 0 cracks are worn off."""
        return np.asarray(self.cracks - self.wear)


def t_gamma_damage(t_gamma_N: Floats) -> TGammaDamage:
    """Damage of one axle by T-gamma of a patch, see `TGammaDamage`; the last branch is prolonged."""
    begins, most, balanced = WLRM_T_GAMMA_N
    t_gamma = as_numbers("t_gamma_damage(t_gamma_N)", t_gamma_N)
    if not np.isfinite(t_gamma).all():
        raise InputError("t_gamma_damage: some T-gamma not finite", "numbers in N", "leave out what did not converge")
    cracks = np.interp(t_gamma, (begins, most), (0.0, WLRM_MAX_DAMAGE))
    wear = WLRM_MAX_DAMAGE * np.maximum(t_gamma - most, 0.0) / (balanced - most)
    return TGammaDamage(np.asarray(cracks), np.asarray(wear))


def shakedown_index(max_pressure: float, k_MPa: float, utilised_friction: float) -> float:
    """p0 / k over the limit of shakedown of a circular patch at a traction coefficient: above 1 steel ratchets."""
    check_positive("shakedown_index", "k_MPa", k_MPa, advice="give the yield strength in shear")
    limits = shakedown_limits("point", min(utilised_friction, 1.0))
    return float(max_pressure / k_MPa / limits.shakedown)


class DangVan(Record):
    """Criterion of Dang Van: ``tau(t) + slope * hydrostatic(t) <= limit_MPa`` at all times.

    tau is half of Tresca's stress of the deviator about the centre of the smallest ball, by von Mises' norm, around its
    history: residual stresses that shakedown leaves in grains make it the centre.
    """

    limit_MPa: Positive  # noqa: N815
    """fatigue limit in alternating shear, that of alternating torsion"""
    slope: NotNegative
    """weight of the hydrostatic stress: 3 limit / bending limit - 1.5"""

    def of(self, histories: Floats, residual: Floats | None = None) -> "DangVanStress":
        """Equivalent stress of histories.

        Parameters
        ----------
        histories
            Stresses xx, yy, zz, xy, yz, xz of points over times, tension positive, MPa, shape (n, m, 6). The state
            without load is added.
        residual
            Residual stresses of the points, shape (n, 6) or (6,).

        Raises
        ------
        InputError
            If shapes differ from these, or a stress is not finite.

        """
        given, left = (
            as_numbers("histories", histories),
            as_numbers("residual", np.zeros(6) if residual is None else residual),
        )
        fits = given.ndim == 3 and given.shape[1] > 0 and given.shape[2] == 6 and left.shape in ((6,), (len(given), 6))
        if not (fits and np.isfinite(given).all() and np.isfinite(left).all()):
            raise InputError(
                f"DangVan.of: histories of shape {given.shape}, residual stresses of {left.shape}, or some not finite",
                "finite stresses xx, yy, zz, xy, yz, xz of points over times, (n, m, 6), and (n, 6) or (6,)",
                "give one point as histories[None]",
            )
        stresses = np.concatenate((given, np.zeros_like(given[:, :1])), axis=1)
        stresses = stresses + np.broadcast_to(left, (len(given), 6))[:, None]
        tensors = stresses[..., ((0, 3, 5), (3, 1, 4), (5, 4, 2))]
        pressure = np.trace(tensors, axis1=-2, axis2=-1) / 3.0
        deviators = tensors - pressure[..., None, None] * np.eye(3)
        centres = ball_centres(deviators.reshape(*deviators.shape[:2], 9))
        moved = deviators - centres.reshape(-1, 1, 3, 3)
        principal = np.linalg.eigvalsh(moved)
        values = 0.5 * (principal[..., 2] - principal[..., 0]) + self.slope * pressure
        worst = values.argmax(axis=1)
        rows = np.arange(len(values))
        axes = np.linalg.eigh(moved[rows, worst])[1]
        normals = np.stack((axes[..., 2] + axes[..., 0], axes[..., 2] - axes[..., 0]), axis=1) / np.sqrt(2.0)
        return DangVanStress(values[rows, worst], values[rows, worst] / self.limit_MPa, worst, normals)


@dataclass(frozen=True, eq=False)
class DangVanStress:
    """Worst moment of points (n,).

    - `equivalent_MPa`: shear stress with the weighted hydrostatic stress.
    - `index`: over the limit; cracks are expected to start above 1.
    - `time`: number of the moment; the last one is that without load.
    - `normals`: normals of the two planes of maximum shear stress at this moment, along which cracks start, (n, 2, 3).
    """

    equivalent_MPa: Floats  # noqa: N815
    index: Floats
    time: Floats
    normals: Floats


def ball_centres(points: Floats) -> Floats:
    """Centres of the smallest balls around sets of points (n, m, d), shape (n, d).

    Frank and Wolfe's method with away steps (Yildirim, 2008, SIAM J. Optim. 19), for all sets at once; its weights say
    which points the ball touches.
    """
    n, m, _ = points.shape
    origin = points[:, :1]
    points = points - origin
    squares = (points**2).sum(axis=2)
    rows = np.arange(n)
    weights = np.zeros((n, m))
    far = squares.argmax(axis=1)
    weights[rows, 0] = 0.5
    weights[rows, far] += 0.5
    active = np.arange(n)
    for _ in range(MAX_BALL_STEPS):
        w, p, s = weights[active], points[active], squares[active]
        centre = np.einsum("nm,nmd->nd", w, p)
        gamma = np.einsum("nm,nm->n", w, s) - (centre**2).sum(axis=1)
        distance = s - 2.0 * np.einsum("nmd,nd->nm", p, centre) + (centre**2).sum(axis=1)[:, None]
        far, near = distance.argmax(axis=1), np.where(w > 0.0, distance, np.inf).argmin(axis=1)
        number = np.arange(len(active))
        scale = np.maximum(gamma, np.finfo(float).tiny)
        beyond, inside = distance[number, far] / scale - 1.0, 1.0 - distance[number, near] / scale
        left = (np.maximum(beyond, inside) > BALL_TOLERANCE) & (gamma > np.finfo(float).tiny)
        if not left.any():
            break
        towards = beyond > inside
        at_near = w[number, near]
        step = np.where(
            towards,
            beyond / (2.0 * (1.0 + beyond)),
            -np.minimum(inside / (2.0 * np.maximum(1.0 - inside, 1e-300)), at_near / np.maximum(1.0 - at_near, 1e-300)),
        )
        w = w * (1.0 - step)[:, None]
        w[number, np.where(towards, far, near)] += step
        weights[active] = np.where(left[:, None], np.maximum(w, 0.0), weights[active])
        active = active[left]
    return np.asarray(np.einsum("nm,nmd->nd", weights, points) + origin[:, 0])
