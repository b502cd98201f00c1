"""The scene of a trial: robot, object, supports and camera in one MuJoCo model."""
