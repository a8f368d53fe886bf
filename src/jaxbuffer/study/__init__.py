"""Studies as TOML: read, overridden, written."""
