"""Contact locus of S1002 on 60E1 beside the Manchester contact benchmark, and its equivalent conicity.

Source: Manchester contact benchmark (P. Shackleton, S. Iwnicki, "Comparison of wheel-rail contact codes for railway
vehicle simulation", Vehicle System Dynamics 46, 2008), case A-2.2: new S1002 on new UIC60 at 1:40, gauge 1435 mm
14 mm below the tops, back-to-back 1360 mm, rolling radius 460 mm, 20 kN. Numbers: reference outputs of the program
CONTACT (E. Vollebregt, Vtech CMCC; open source, Apache License 2.0), examples mbench_a22_left and mbench_a22_right.

What they are: each wheel bears 10 kN, and the position given is the middle of its overlap weighted by depth, which is
up to 24 mm wide where the profiles conform; yaw grows by 2.4 mrad per mm of lateral motion. The rigid reference here
has one point and no yaw.
"""

import numpy as np
import pytest

from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import Track, WheelPair

PUBLISHED = {
    # lateral motion in mm: roll in mrad; depth in mm below the reference height, loaded, of the first touch on the
    # right and on the left; x in mm of the contact on the right and on the left rail; contact angles in rad
    0.0: (0.0, 0.1981, 0.1821, 0.1821, 751.873, -751.873, 0.0290, 0.0290),
    0.5: (0.02304, 0.1938, 0.1743, 0.1759, 744.503, -754.209, 0.0568, 0.0211),
    1.0: (0.05049, 0.1839, 0.1593, 0.1645, 741.991, -755.244, 0.0696, 0.0176),
    1.5: (0.08103, 0.1694, 0.1444, 0.1494, 741.377, -755.967, 0.0753, 0.0152),
    2.0: (0.1128, 0.1529, 0.1280, 0.1324, 740.915, -756.506, 0.0806, 0.0134),
    2.5: (0.1457, 0.1344, 0.1097, 0.1138, 740.462, -756.918, 0.0862, 0.0121),
    3.0: (0.1803, 0.1143, 0.0898, 0.0932, 739.970, -757.236, 0.0923, 0.0110),
    3.5: (0.2168, 0.0921, 0.0678, 0.0708, 739.407, -757.480, 0.0994, 0.0102),
    4.0: (0.2557, 0.0676, 0.0437, 0.0462, 738.738, -757.664, 0.1078, 0.0096),
    4.5: (0.2977, 0.0404, 0.0171, 0.0189, 737.890, -757.799, 0.1185, 0.0091),
    5.0: (0.3554, 0.0015, -0.0271, -0.0205, 727.086, -757.896, 0.2905, 0.0088),
    5.5: (0.4777, -0.0866, -0.1176, -0.1091, 726.117, -757.975, 0.3363, 0.0085),
    6.0: (0.6272, -0.1961, -0.2259, -0.2185, 725.137, -758.021, 0.4176, 0.0084),
    6.5: (4.376, -3.0468, -3.1382, -3.0696, 718.493, -758.624, 1.1591, 0.0064),
    7.0: (6.393, -4.5809, -4.6549, -4.6045, 719.044, -758.609, 1.0634, 0.0064),
}
TABLE = np.array(list(PUBLISHED.values()))
LATERAL = np.array(list(PUBLISHED))
BOTH = np.concatenate((-LATERAL[:0:-1], LATERAL))
RAIL_X = np.concatenate((-TABLE[:0:-1, 5], TABLE[:, 4]))
"""X of the contact on the right rail for lateral motions of -7 to 7 mm: the left rail's, mirrored, and the right's."""

ANGLES = np.concatenate((TABLE[:0:-1, 7], TABLE[:, 6]))


@pytest.fixture(scope="module")
def benchmark():
    """Wheels and rails of the benchmark as rigid curves."""
    track = Track(rail="60E1", gauge_mm=1435.0, inclination=1.0 / 40.0)
    return RigidGeometry.of(track, WheelPair(wheel="S1002", back_to_back_mm=1360.0, radius_mm=460.0))


@pytest.fixture(scope="module")
def locus(benchmark):
    """Positions and contacts for lateral motions of -7 to 7 mm, as in the table."""
    return benchmark.locus(BOTH)


def test_contact_points_over_lateral_motion(locus):
    """From -7 to 7 mm the points on the right rail agree to 0.27 mm where it runs on the tread, 0.6 mm at the flange.

    Left out are 0 and 0.5 mm to either side, where the published overlap spans both sides of a jump; see below.
    """
    difference = locus.right.points_mm[:, 0, 0] - RAIL_X
    on_tread, at_flange = BOTH <= -1.0, BOTH >= 1.0
    assert on_tread.sum() == at_flange.sum() == 13
    assert np.abs(difference[on_tread]).max() < 0.27
    assert np.abs(difference[at_flange]).max() < 0.6
    assert np.abs(difference[BOTH >= 5.5]).max() < 0.12
    # beside the jump at the middle the weighted middle of a wide overlap is elsewhere than its deepest point
    assert abs(difference[list(BOTH).index(-0.5)]) < 0.5


def test_contact_angles(locus):
    """Contact angles agree to 0.3 degrees on tread and flange root, and to 1.3 degrees on the steep flange."""
    difference = np.degrees(np.abs(locus.right.contact_angles_rad[:, 0] - ANGLES))
    one_place = np.abs(BOTH) >= 1.0
    assert difference[one_place & (BOTH <= 4.5)].max() < 0.3
    assert difference[one_place].max() < 1.3


def test_jumps(benchmark, locus):
    """The rigid wheel jumps where the published points do: about 0.25, between 4.5 and 5, and between 6 and 6.5 mm.

    The published points move by more than 6 mm in these steps of 0.5 mm (the first by 7.4, into the middle of both
    places), and by less than 2.6 mm in each other one; the rigid points do the same.
    """
    jumps = [jump for jump in benchmark.jumps(7.0) if jump.side == "right"]
    at = np.array([jump.motion.lateral_mm for jump in jumps])
    assert ((at > 0.0) & (at < 0.5)).any()
    assert ((at > 4.5) & (at < 5.0)).any()
    assert ((at > 6.0) & (at < 6.5)).any()
    assert (((at > 0.0) & (at < 0.5)) | ((at > 4.5) & (at < 5.0)) | ((at > 6.0) & (at < 6.5))).all()
    published, rigid = np.diff(RAIL_X), np.diff(locus.right.points_mm[:, 0, 0])
    starts = BOTH[:-1]
    jumping = np.isin(starts, [0.0, 4.5, 6.0])
    for moved in (published, rigid):
        assert (moved[jumping] < -6.0).all()
        assert np.abs(moved[~jumping]).max() < 2.6
    # the jump to the flange is the same to a tenth of a millimetre, that to the flange root to 1.1 mm in 11
    assert rigid[starts == 6.0] == pytest.approx(published[starts == 6.0], abs=0.1)
    assert rigid[starts == 4.5] == pytest.approx(published[starts == 4.5], abs=1.1)


def test_heights_and_roll(locus):
    """Height of the first touch to 1 micrometre in the middle and 0.025 mm before the flange climbs; roll to 7 %."""
    n = len(LATERAL)
    height, roll = locus.vertical_mm[-n:], 1e3 * locus.roll_rad[-n:]
    published = -TABLE[:, 2:4].mean(axis=1)
    assert height[0] == pytest.approx(published[0], abs=1e-3)
    before = LATERAL <= 6.0
    assert np.abs(height - published)[before].max() < 0.025
    assert np.abs(height - published)[~before].max() < 0.2
    assert roll == pytest.approx(TABLE[:, 0], rel=0.07, abs=1e-6)
