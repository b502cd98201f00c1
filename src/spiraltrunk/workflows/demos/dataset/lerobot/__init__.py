"""LeRobotDataset v3.0: Parquet files of frames and episodes, and a video of each camera."""
