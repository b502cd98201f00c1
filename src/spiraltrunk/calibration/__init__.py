"""Calibration: parameters of one real trunk, fitted to recordings and to joints on a bench."""
