"""Tab *Measure*: recordings of motion capture over the model, and the calibration of a trunk from them."""
