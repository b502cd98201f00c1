"""Log of a run on hardware or twin, readable after a crash."""

from spiraltrunk.hardware.log.metadata import LogMetadata
from spiraltrunk.hardware.log.reader import Log, load_log
from spiraltrunk.hardware.log.recording import LoggedPlant
from spiraltrunk.hardware.log.replay import build_run_log, describe_task
from spiraltrunk.hardware.log.writer import LogWriter

__all__ = ["Log", "LogMetadata", "LogWriter", "LoggedPlant", "build_run_log", "describe_task", "load_log"]
