"""Runge-Kutta methods: tableaus, stages, step size control, the time transform."""
