"""Worker processes that end with their parent."""
