"""A session: registered static shapes of the sections from takes and protocol, with predictions."""
