"""Export of a design: printable parts and simulation models, checked against the design."""
