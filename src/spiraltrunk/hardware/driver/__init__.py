"""Driver of a trunk: one loop over motors, gripper and arm that keeps them safe."""
