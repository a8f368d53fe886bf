"""The loop of error-controlled steps that ends a step on every event."""
