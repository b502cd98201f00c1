"""Tab "Design": every parameter of a design, its live picture, its figures, its file and its parts."""
