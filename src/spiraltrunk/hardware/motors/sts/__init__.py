"""Feetech STS bus servos: their registers, models, line and discovery."""
