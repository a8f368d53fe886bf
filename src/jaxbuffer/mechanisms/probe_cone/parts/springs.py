"""The springs and dampers of the buffer, and the cylinder between them."""

from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, number
from ....suggestions import same_word

same_word("stroke", "shortening")
same_word("along", "axial", "cylinder", "a")
same_word("about", "torsional", "angular", "rotational", "hinge", "t")


class SpringFields(Part):
    """Axial (M23) and torsional (M26) spring-dampers, and the cylinder between them, a slender rod (M5)."""

    k_A: Number = number(500.0, "N/m", **POSITIVE, doc="stiffness along the cylinder")
    c_A: Number = number(5.0, "N s/m", **NON_NEGATIVE, doc="damping along the cylinder")
    k_T: Number = number(300.0, "N m/rad", **POSITIVE, doc="stiffness about the hinge")
    c_T: Number = number(2.0, "N m s/rad", **NON_NEGATIVE, doc="damping about the hinge")
    free_length: Number = number(0.1365, "m", **POSITIVE, doc="free length l_0 of the axial spring")
    cylinder_mass: Number = number(1.0, "kg", **POSITIVE, doc="mass m_B of the cylinder")
    cylinder_length: Number = number(0.1365, "m", **POSITIVE, doc="length L_C of the cylinder, a slender rod")
