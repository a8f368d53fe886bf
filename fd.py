import time, jax, jax.numpy as jnp, numpy as np
import jaxbuffer as jb; jb.configure()
d, s = jb.TankDrop(), jb.TankDropScenario()
thick = jb.replace(d, {f"wall.{z}": 0.012 for z in ("bottom","lower_corner","lower_side","upper_side","upper_corner","top")})
s = jb.replace(s, {"height":0.3})
from jaxbuffer.mechanisms.tank_drop.assembly import assembled, at_rest
from jaxbuffer.mechanisms.tank_drop.stepping import dropped
from jaxbuffer.run.request import options_of
T=0.02
def f(fill):
    r=jb.simulate(thick, jb.replace(s,{"fill":fill}), T); return jnp.array([r.deflection, r.peak_force, r.peak_stress])
fj=jax.jit(f)
for h in (1e-5,1e-6,1e-7,1e-8):
    print(h, np.array((fj(0.8+h)-fj(0.8-h))/(2*h)))
def parts(fill):
    p=assembled(thick, jb.replace(s,{"fill":fill})); st=at_rest(p)
    return {"pos":p.system.positions,"im":p.system.inverse_mass,"sp":p.system.static_pressure,"lq":p.section.liquid,"K":p.system.liquid.stiffness,"M":p.system.liquid.mass,"out":p.system.liquid.outward,"w":p.system.layers[0].width,"u":st.displacement,"q":p.system.elements[0].quads.gradient,"h":p.system.elements[0].quads.hourglass_gradient,"ax":p.system.elements[0].quads.axes}
J=jax.jit(jax.jacfwd(parts))(0.8); pj=jax.jit(parts); h=1e-6
a,b=pj(0.8+h),pj(0.8-h)
for k in J:
    fd=(a[k]-b[k])/(2*h); print(k, float(jnp.abs(J[k]-fd).max()), float(jnp.abs(fd).max()))
