"""From a design to parts and models on disc, checked against the design."""
