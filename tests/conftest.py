"""Settings for all tests."""

from hypothesis import HealthCheck, settings

settings.register_profile("spiraltrunk", deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("spiraltrunk")
