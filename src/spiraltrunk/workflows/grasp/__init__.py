"""One trial: a scene drawn from a seed, a strategy in it, its verdict and its artifacts."""
