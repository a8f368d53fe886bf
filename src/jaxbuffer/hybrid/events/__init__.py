"""Guards, where they cross zero within a step, and bracketing a crossing."""
