"""Fields: numbers with unit, range and meaning, their dotted paths, one address for design and scenario."""

from .address import SCENARIO as SCENARIO
from .address import addresses as addresses
from .address import check_address as check_address
from .address import check_alone as check_alone
from .address import check_numbers as check_numbers
from .address import unit_at as unit_at
from .address import value_at as value_at
from .address import with_values as with_values
from .declared import NON_NEGATIVE as NON_NEGATIVE
from .declared import POSITIVE as POSITIVE
from .declared import Part as Part
from .declared import Portable as Portable
from .declared import all_of as all_of
from .declared import choice as choice
from .declared import number as number
from .declared import whole as whole
from .paths import by_path as by_path
from .paths import check_path as check_path
from .paths import get as get
from .paths import limits_of as limits_of
from .paths import metadata as metadata
from .paths import paths as paths
from .paths import replace as replace
from .paths import unit as unit
from .units import check_units_agree as check_units_agree
from .units import in_unit as in_unit
