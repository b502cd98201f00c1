"""The assembly guide: its steps, and the tools that they name."""
