"""# The contact laws side by side

One impact of two free bodies under each built-in law: force over penetration, force over time, and the restitution that
a law delivers over the requested one.
"""

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone.comparison import compare_laws
from jaxbuffer.output.laws_figure import laws_figure

jb.configure()
figure = laws_figure(compare_laws(jb.table2()))
