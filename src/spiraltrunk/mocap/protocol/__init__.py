"""The protocol of a session: what is recorded, its schedule, its checklist and its TOML file."""
