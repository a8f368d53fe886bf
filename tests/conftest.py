"""Every test runs in double precision and with strict rank promotion, and may leave evidence for the report."""

from pathlib import Path

import pytest

import jaxbuffer.compiling.process

jaxbuffer.compiling.process.configure()

import jax  # noqa: E402

from evidence import Evidence  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")

EVIDENCE = Evidence()


@pytest.fixture(scope="session")
def evidence():
    """Asserts a measured error and remembers it; see `Evidence`."""
    return EVIDENCE


def pytest_addoption(parser):
    parser.addoption("--evidence", type=Path, help="write what tests measured to this JSON file")


def pytest_sessionfinish(session):
    if path := session.config.getoption("--evidence"):
        EVIDENCE.write(path)
