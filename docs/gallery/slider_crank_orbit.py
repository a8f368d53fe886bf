"""# A pin's orbit in its bush

A slider-crank with play: where the piston pin's centre goes in its bush during a turn. The circle is where the pin
touches; beyond it the contact is pressed in.
"""

import numpy as np
from matplotlib.figure import Figure

import jaxbuffer as jb

jb.configure()
run = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(), history=True)
history = jb.at_times(run, np.linspace(0.0, float(run.end_time), 5000)).others
x, y = 1e3 * history["piston_pin_x"], 1e3 * history["piston_pin_y"]  # mm
clearance = 1e3 * run.design.piston_pin.clearance
angle = np.linspace(0.0, 2.0 * np.pi, 200)

figure = Figure(figsize=(5.5, 5.5), layout="constrained")
axes = figure.subplots()
axes.plot(x, y, linewidth=0.9, label="centre of the pin")
axes.plot(clearance * np.cos(angle), clearance * np.sin(angle), "k--", linewidth=0.9, label="clearance")
axes.set(xlabel="along the slider's line [mm]", ylabel="across [mm]", aspect="equal")
axes.legend(loc="upper right")
