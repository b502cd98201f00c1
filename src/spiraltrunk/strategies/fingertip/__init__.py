"""Fingertip grasps: the gripper at the tip holds, as in pinch, tip grip and flip grip."""
