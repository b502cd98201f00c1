"""One open page: its controls, its settings, its messages, and the work that it started."""
