"""Two surveys of the same worlds: in which strategies their success rates differ.

`paired` has the statistics, `compare_surveys` the comparison, `comparison_text` its table.
"""
