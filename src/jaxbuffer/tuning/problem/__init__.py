"""The design problem as data: load cases, variables, objective, limits, tolerances."""
