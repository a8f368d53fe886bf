"""Flexible bodies: their modes, made once outside of a run, for planar floating frames of reference.

Names are imported when they are first used, because scikit-fem and SciPy, for planar shapes, take long to import.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
