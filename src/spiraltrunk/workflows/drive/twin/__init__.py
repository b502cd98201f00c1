"""The whole robot as a twin: motors, bus and driver around the simulated machine."""
