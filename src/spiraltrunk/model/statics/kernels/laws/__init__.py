"""Laws of the trunk, one kernel each: joint rotation and limit, gravity, cable gaps, capstan friction, energy."""
