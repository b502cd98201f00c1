"""From recordings or bench measurements to one fitted trunk, with its errors on held-out takes."""
