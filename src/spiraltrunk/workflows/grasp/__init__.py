"""One trial: a drawn world, a strategy in it, the verdict, and the files that it leaves."""
