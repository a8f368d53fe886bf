"""What a message suggests for a name that people use for something that is called otherwise here."""

import pytest

from jaxbuffer.errors import InputError
from jaxbuffer.fields import meaning, paths
from jaxbuffer.mechanisms.probe_cone import Scenario, table2
from jaxbuffer.study.load import loads
from jaxbuffer.suggestions import suggest
from jaxbuffer.tuning.problem.objective import quantity_in_words

QUANTITIES = ("captured", "impacts", "peak_force", "peak_hinge_force", "peak_stop_force", "stroke", "end_time")
SPAN = "expected [0.1, 0.2] or {from = 0.1, to = 0.2, count = 5}"


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("peak_contact_force", "peak_force"),
        ("contact_force", "peak_force"),
        ("max_force", "peak_force"),
        ("peak_froce", "peak_force"),
        ("hinge_force", "peak_hinge_force"),
        ("stop_force", "peak_stop_force"),
        ("max_stroke", "stroke"),
        ("duration", "end_time"),
        ("success", "captured"),
    ],
)
def test_a_quantity_is_found_by_its_words_and_by_what_else_it_is_called(name, meant):
    assert suggest(name, QUANTITIES, quantity_in_words) == f"; did you mean {meant}?"


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("buffer.torsional_stiffness", "buffer.k_T"),
        ("buffer.angular_damping", "buffer.c_T"),
        ("cone.angle", "cone.half_angle"),
        ("contact.mu", "contact.friction"),
        ("contact.coefficient_of_restitution", "contact.restitution"),
        ("hinge.clearance", "hinge.play"),
        ("active.weight", "active.mass"),
        ("active.moment_of_inertia", "active.inertia"),
    ],
)
def test_a_field_of_a_design_is_found_by_its_meaning(name, meant):
    design = table2()
    assert suggest(name, list(paths(design)), lambda path: meaning(design, path)) == f"; did you mean {meant}?"


def test_a_word_that_several_fields_mean_names_them_all():
    design = table2()
    said = suggest("buffer.stiffness", list(paths(design)), lambda path: meaning(design, path))
    assert "buffer.k_A or buffer.k_T" in said
    assert suggest("angle", list(paths(Scenario())), lambda path: meaning(Scenario(), path)) == (
        "; did you mean misalignment or active_angle?"
    )


@pytest.mark.parametrize(
    ("study", "said"),
    [
        (
            '[problem.grid]\nstart = "free"',
            'start = \'free\' is not a list of choices; write some of ["contact", "free"]',
        ),
        ('[problem.grid]\nstart = ["fre"]', "start = 'fre' is unknown; choose one of contact, free"),
        ('[problem.grid]\nstart = ["free", "free"]', "names free twice"),
        ("[sweep]\nscenario.approach_speed = {start = 0.1, stop = 0.2, num = 4}", f"did you mean from?; {SPAN}"),
        ("[sweep]\nscenario.approach_speed = {min = 0.1, max = 0.2}", f"did you mean from?; {SPAN}"),
        ("[sweep]\nscenario.approach_speed = {from = 0.1, to = 0.2, num = 4}", f"did you mean count?; {SPAN}"),
        ("[problem.grid]\napproach_speed = {start = 0.1, stop = 0.2, num = 4}", f"did you mean from?; {SPAN}"),
        ("[sweep]\nscenario.start = {first = 'free'}", 'is a choice; list its values, as in ["contact", "free"]'),
        ("[sweep]\nscenario = 3", "scenario is unknown: it is a section; name one of its fields"),
        ("[problem.variables]\nbuffer.k_A = {from = 100, to = 200}", "must be [low, high] in N/m"),
        ("[problem.variables]\nscenario.approach_speed = [1, 2]", "only numbers of the design can be tuned"),
        ("[problem.sample]\nscenario.approach_speed = {low = 1, high = 2}", "must be { uniform = [low, high] }"),
        ("[sample]\ncount = 4\nranges.buffer.k_A = {min = 1, max = 2}", "must be low and high end in N/m"),
        ("[problem.constraints]\nstroke = {at_most = 0.1}", "at_most is unknown; did you mean max?"),
        ("[problem.constraints]\nstroke = [0.1, 0.2]", "is a list; write stroke = {min = 0.1, max = 0.2}"),
        ("[problem.limits]\nstroke = 3", "problem.limits is unknown; did you mean constraints?"),
        ("[constraints]\nstroke = 3", "[constraints] is unknown; did you mean [problem.constraints]?"),
        ("[optimize]\nstarts = 3", "[optimize] is unknown; did you mean [tune]?"),
        ("[problem.objective]\nover = 'max'", "choose one of worst, mean, cvar; did you mean worst?"),
        ("[sample]\nmethod = 'lhs'", "did you mean latin_hypercube?"),
        ("[options]\nt_end = 3", "did you mean options.duration?"),
    ],
)
def test_a_mistaken_study_says_what_it_should_be(study, said):
    with pytest.raises(InputError) as error:
        loads(study.encode(), "study.toml")
    assert said in str(error.value)


def test_a_grid_takes_the_choices_of_a_scenario():
    problem = loads(b'[problem.grid]\nstart = ["contact", "free"]\napproach_speed = [0.1, 0.2]', "study.toml").problem()
    assert [(case.scenario.start, case.scenario.approach_speed) for case in problem.cases] == [
        ("contact", 0.1),
        ("contact", 0.2),
        ("free", 0.1),
        ("free", 0.2),
    ]
