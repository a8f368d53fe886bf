"""Every test runs in double precision, with strict promotion and with array shapes checked at run time."""

from jaxtyping import install_import_hook

import jaxbuffer.runtime

jaxbuffer.runtime.configure()

import jax  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")
