"""Learning of policies: behaviour cloning of recorded episodes, and the worlds in which a stroke is learned by trial.

`episodes` records, `samples` turns episodes into what a network takes and gives, `cloning` trains; `stroke_world` is
the world of `benchmarks/train_reinforcement.py`. `spiraltrunk.report.learning_curve` draws the losses.
"""
