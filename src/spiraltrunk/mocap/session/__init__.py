"""A session: takes and protocol become registered static shapes of sections, with predictions beside them."""
