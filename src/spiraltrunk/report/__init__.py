"""Plots, film strips, videos and tables of a run. Drawing packages are imported when used."""

from spiraltrunk.report.table import format_table
from spiraltrunk.report.trial.figures import Series, write_plots
from spiraltrunk.report.trial.filmstrip import write_filmstrip
from spiraltrunk.report.trial.video import write_video

__all__ = ["Series", "format_table", "write_filmstrip", "write_plots", "write_video"]
