"""The motor housing: winders, layout, lid, housing and test stand."""
