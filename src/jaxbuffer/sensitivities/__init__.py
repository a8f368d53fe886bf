"""Gradients and elasticities of a run's quantities, with a certificate of how far to trust them."""
