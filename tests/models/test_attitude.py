"""Attitude against SciPy's rotations."""

import math

import numpy as np
from hypothesis import given
from scipy.spatial.transform import Rotation

from models.attitude import quaternion_from_rpy_radians, rotation_of
from tests.strategies import numbers


@given(numbers(-math.pi, math.pi), numbers(-math.pi, math.pi), numbers(-math.pi, math.pi))
def test_angles_and_quaternions_are_scipys(roll, pitch, yaw):
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    quaternion = quaternion_from_rpy_radians(roll, pitch, yaw)
    other = expected.as_quat(scalar_first=True)
    np.testing.assert_allclose(quaternion, other * np.sign(quaternion @ other), atol=1e-15)
    np.testing.assert_allclose(rotation_of(quaternion), expected.as_matrix(), atol=1e-15)


def test_roll_lowers_the_starboard_wing_pitch_raises_the_nose_and_yaw_turns_it_to_starboard():
    nose, starboard = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    assert (rotation_of(quaternion_from_rpy_radians(0.2, 0.0, 0.0)) @ starboard)[2] > 0.0
    assert (rotation_of(quaternion_from_rpy_radians(0.0, 0.2, 0.0)) @ nose)[2] < 0.0
    assert (rotation_of(quaternion_from_rpy_radians(0.0, 0.0, 0.2)) @ nose)[1] > 0.0
