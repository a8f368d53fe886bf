"""The slider-crank with play in its pins."""

from .design import SliderCrank as SliderCrank
from .design import SliderCrankScenario as SliderCrankScenario
from .journal import journal_path as journal_path
from .mechanism import SLIDER_CRANK as SLIDER_CRANK
from .published import published_slider_crank as published_slider_crank
from .statistics import turn_statistics as turn_statistics
