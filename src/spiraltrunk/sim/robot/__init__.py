"""The robot in MuJoCo: arm, trunk, gripper, cable friction and inverse kinematics of the arm."""
