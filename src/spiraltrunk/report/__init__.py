"""What a run looked like: plots, film strips, videos and tables. Drawing packages are imported when used."""

from spiraltrunk.report.filmstrip import write_filmstrip
from spiraltrunk.report.plots import write_overview, write_plots
from spiraltrunk.report.series import Series
from spiraltrunk.report.table import format_table
from spiraltrunk.report.video import write_video

__all__ = ["Series", "format_table", "write_filmstrip", "write_overview", "write_plots", "write_video"]
