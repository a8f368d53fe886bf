"""What no evidence exists for. Say so here until there is some."""

GAPS = (
    ("absolute forces of the paper", "its figures are lost and its text prints no force"),
    ("any measurement", "no experiment on this mechanism is at hand; every check is of the model's solution"),
    ("the paper's own solver", "its form D(y) y' = F(y) is solved by IDA, by backward differences like ode15s"),
    (
        "the assumed numbers",
        "restitution 0.9, slip speed 1e-3 m/s, probe and tip masses, flank length: the paper's text gives none of them",
    ),
    ("the paper's «all values»", "it names neither its approach speeds, misalignments nor friction coefficients"),
    ("contact at speeds where metal yields", "Hertz's law is elastic; no law here knows plasticity"),
    ("motion out of the plane", "the model is planar: a real probe meets a cone in space"),
    (
        "gradients where the outcome or the largest impact switches",
        "the peak force has a kink there, hence no gradient",
    ),
    ("gradients after hundreds of impacts", "the captures they are checked on have some tens of impacts at most"),
)
