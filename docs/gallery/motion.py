"""# The motion in pictures

The mechanism in scale at telling moments of a capture: the start, the largest impacts and the end, with the contact
forces as arrows.
"""

import jaxbuffer as jb

jb.configure()
scenario = jb.Scenario(approach_speed=0.15, misalignment="3 deg")
figure = jb.draw(jb.simulate(jb.table2(), scenario, history=True))
