"""The trunk and gripper as printed parts."""
