"""Tab *Shape*: cables, gravity and tip of the trunk, its equilibrium, and the paper's model beside it."""
