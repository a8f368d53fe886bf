import time, jax, jax.numpy as jnp, numpy as np
import jaxbuffer as jb; jb.configure()
from jaxbuffer.mechanisms.tank_drop.assembly import *
from jaxbuffer.mechanisms.tank_drop import stepping as S
from jaxbuffer.structures.central_differences import march, advance
d, s = jb.TankDrop(), jb.TankDropScenario()
def timed(name, f, *a, n=3):
    t=time.time(); c=jax.jit(f).lower(*a).compile(); t1=time.time()-t
    r=jax.block_until_ready(c(*a)); best=9
    for _ in range(n):
        t=time.time(); jax.block_until_ready(c(*a)); best=min(best,time.time()-t)
    txt=c.as_text(); 
    print(f"{name}: compile {t1:.1f} s, run {best*1e3:.2f} ms; fusions {txt.count(' fusion(')}, whiles {txt.count(' while(')}", flush=True)
    return r
timed("stable", lambda d,s: assembled(d,s).system.stable_step(), d, s)
timed("rest", lambda d,s: at_rest(assembled(d,s)).displacement, d, s)
def steps(d,s,kind):
    p=assembled(d,s); st=p.system.start(); st=st._replace(velocity=st.velocity.at[p.slider,1].set(-6.))
    def one(c,_):
        after, ins = advance(p.system, c[0], 2e-6, (None,))
        if kind=="see": seen=S._seen(p, 2e-6, c[1], ins)
        elif kind=="min": seen=c[1]
        return (after, seen), None
    first=S._nothing_seen(p, st, False)
    return jax.lax.scan(one,(st,first),length=1000)[0]
for kind in ("min","see"):
    timed(kind, lambda d,s: steps(d,s,kind), d, s)
