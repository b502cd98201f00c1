"""What is bought and how parts are made: fasteners, and the options of the printer."""
