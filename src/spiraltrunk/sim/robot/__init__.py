"""The robot in MuJoCo: arm, trunk, gripper, their materials, cable friction and arm kinematics."""
