"""What environments show: spaces, pictures, and the truth where it is asked for."""
