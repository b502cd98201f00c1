"""Calibration: which trunk one has, fitted to recordings and to joints on a bench."""
