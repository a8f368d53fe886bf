"""Settings of the process, and compiled programs stored on disk."""
