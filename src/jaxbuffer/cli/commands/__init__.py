"""What the commands do. These modules import JAX: `cli.options` imports one of them when its command runs."""
