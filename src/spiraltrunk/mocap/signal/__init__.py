"""Signal processing of takes: gaps, static segments, registration and deviations."""
