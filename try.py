import time, jax, jax.numpy as jnp, numpy as np
import jaxbuffer as jb; jb.configure()
jax.config.update("jax_numpy_rank_promotion", "raise")
from jaxbuffer.mechanisms.tank_drop.assembly import *
d, s = jb.TankDrop(), jb.TankDropScenario()
thick = jb.replace(d, {f"wall.{z}": 0.012 for z in ("bottom","lower_corner","lower_side","upper_side","upper_corner","top")})
t=time.time(); run = jb.simulate(thick, jb.replace(s, {"height":0.3}), 0.08); print(run.outcome, time.time()-t)
for dd,h in ((thick,0.3),(thick,2.04),(d,2.04)):
    t=time.time(); run = jb.simulate(dd, jb.replace(s, {"height":h}), 0.08, history=False); jax.block_until_ready(run.peak_force); print(time.time()-t, run.attempts, run.outcome.name)
    print({n: float(f"{float(q.of(run)):.5g}") for n,q in run.mechanism.quantities.items()})
    print(run.balance.energy, run.balance.linear_momentum, run.energy.total, {**run.energy.stored, **run.energy.lost})
