"""# A sweep as maps

Four quantities over speed and misalignment. Runs that end otherwise than captured carry a mark of their own.
"""

import jaxbuffer as jb
from jaxbuffer.output.sweep_figures import sweep_figure

jb.configure()
over = {
    "scenario.approach_speed": {"from": "5 cm/s", "to": "25 cm/s", "count": 15},
    "scenario.misalignment": {"from": "-6 deg", "to": "6 deg", "count": 13},
}
figure = sweep_figure(jb.sweep(jb.table2(), jb.Scenario(), over=over))
