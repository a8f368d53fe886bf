"""*Load assessment and analysis of impacts in multibody systems* (Multibody System Dynamics, 2016): the kinetic energy
that an impact's constraints concern, as a measure of how hard it is."""

from ..study import Paper, PaperPart
from .claims import CLAIMS
from .figures import figure
from .samples import COLUMNS, SHOWN, STUDIES, row, solve

PAPER = Paper(
    "load",
    "Load assessment and analysis of impacts in multibody systems",
    "Of the paper's text its abstract, a note and the appendix are at hand: its own examples cannot be compared. In "
    "their place stand three mechanisms with masses, lengths, postures and speeds at random, each with one law; "
    "the peaks are in the energies' order where the rank correlation is 0.95 or more.",
    (PaperPart(STUDIES, COLUMNS, SHOWN, row, CLAIMS, figure, solve=solve),),
)
