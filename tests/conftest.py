"""Every test runs in double precision and with strict rank promotion."""

import jaxbuffer.runtime

jaxbuffer.runtime.configure()

import jax  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")
