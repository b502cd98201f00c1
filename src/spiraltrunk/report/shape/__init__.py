"""Pictures of shapes: the trunk from the side and in space, workspace, measured against predicted."""
