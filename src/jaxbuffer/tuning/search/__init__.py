"""The search for the best design: runs with their slopes, constraints, steps, what is stored."""
