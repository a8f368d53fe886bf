"""# Where it is safe: a sweep and its largest rectangle

Captures over speed and misalignment. A run is safe if it is captured and keeps the limit on its stroke. The rectangle
is the largest one that holds safe runs only; the border is drawn around all of them.
"""

import jaxbuffer as jb
from jaxbuffer.output.envelope_figure import envelope_figure

jb.configure()
over = {
    "scenario.approach_speed": {"from": "5 cm/s", "to": "25 cm/s", "count": 15},
    "scenario.misalignment": {"from": "-6 deg", "to": "6 deg", "count": 13},
}
sweep = jb.sweep(jb.table2(), jb.Scenario(), over=over)
figure = envelope_figure(jb.safe_rectangle(sweep, jb.Limits(at_most={"stroke": 0.02})))  # m
