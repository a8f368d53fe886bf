"""Sensitivities as rows of the state, and the linear map that moves them."""
