import time, jax, jax.numpy as jnp, numpy as np
import jaxbuffer as jb; jb.configure()
d, s = jb.TankDrop(), jb.TankDropScenario()
thick = jb.replace(d, {f"wall.{z}": 0.012 for z in ("bottom","lower_corner","lower_side","upper_side","upper_corner","top")})
s = jb.replace(s, {"height":0.3})
T=0.02
def q(name):
    def f(x):
        dd = jb.replace(thick, {"wall.top": x[0], "cushion.stiffness": x[1]}); ss=jb.replace(s, {"fill": x[2]})
        return jb.simulate(dd, ss, T).quantity(name)
    return f
x=jnp.array([0.012, 4e6, 0.8])
f=q("peak_force"); 
fj=jax.jit(f); t=time.time(); v=fj(x); print("fwd compile", time.time()-t); t=time.time(); fj(x).block_until_ready(); t1=time.time()-t; print("run", t1)
for name in ("peak_force","peak_stress","deflection","smooth_stress"):
    f=q(name); g=jax.jit(jax.value_and_grad(f)); t=time.time(); r=g(x); jax.block_until_ready(r); print("compile", time.time()-t); t=time.time(); r=jax.block_until_ready(g(x)); t2=time.time()-t
    fj=jax.jit(f)
    fd=[]
    for k in range(3):
        h=1e-5*x[k]; e=jnp.zeros(3).at[k].set(h)
        fd.append(float((fj(x+e)-fj(x-e))/(2*h)))
    print(name, float(r[0]), np.array(r[1]), np.array(fd), np.array(r[1])/np.array(fd)-1, "ratio", t2/t1, flush=True)
t=time.time(); S=jb.sensitivity(thick, s, wrt=["wall.top","cushion.stiffness","scenario.fill"], duration=T, quantities=["peak_force","peak_stress","deflection"]); print(time.time()-t); print(S)
