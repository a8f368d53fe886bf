"""Random designs and scenarios around Table 2, for statements about distributions rather than one lucky case."""

import numpy as np

import jaxbuffer as jb

PARAMETERS = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass")


def random_case(seed: int, free_tip: bool = False) -> tuple[jb.Design, jb.Scenario]:
    """One case; ranges as wide as the reference captures'."""
    draw = np.random.default_rng(seed)

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(np.log(low), np.log(high))))

    design = jb.replace(
        jb.table2(),
        {
            "buffer.k_A": log_uniform(100, 5000),
            "buffer.c_A": log_uniform(1, 50),
            "buffer.k_T": log_uniform(80, 1500),
            "buffer.c_T": log_uniform(0.5, 20),
            "probe.tip_mass": log_uniform(0.02, 0.2),
            "probe.free_tip": free_tip,
            "contact.restitution": draw.uniform(0.5, 0.9),
            "contact.friction": draw.uniform(0.0, 0.5),
        },
    )
    scenario = jb.Scenario(
        approach_speed=draw.uniform(0.05, 0.3),
        contact_distance=draw.uniform(0.015, 0.055),
        misalignment=draw.uniform(-0.085, 0.085),
        passive_rate=draw.uniform(-0.0075, 0.0075),
    )
    return design, scenario
