"""One run of any mechanism."""
