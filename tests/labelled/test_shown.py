"""What results and designs print: numbers with their units, in text and in a notebook."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.tables import html, summary_html, table


def test_a_gradient_shows_its_numbers():
    def energy(design):
        return design.buffer.k_A**2 * design.probe.length

    design = jb.table2()
    shown = repr(jax.grad(energy)(design))
    assert "k_A [per N/m] = 200," in shown and "length [per m] = 250000," in shown, "2 k l and k²"
    assert "[N/m]" not in shown and "restitution [-] = 0" in shown
    assert "f64[]" not in shown and "law='lankarani-nikravesh'" in shown


def test_designs_and_scenarios_show_units_and_choices():
    shown = repr(jb.table2())
    assert "k_A [N/m] = 500.0," in shown and "free_tip=False" in shown and "max_stroke [m] = None" in shown
    assert "approach_speed [m/s] = [0.1, 0.2]" in repr(jb.Scenario(approach_speed=[0.1, 0.2]))
    assert "… 9 in all]" in repr(jb.Scenario(approach_speed=np.linspace(0.1, 0.2, 9)))
    assert repr(jb.BarDropScenario(height=jnp.asarray(0.125))) == (
        "BarDropScenario(height [m] = 0.125, gravity [m/s²] = 9.81)"
    )


def test_traced_numbers_stay_as_they_are():
    seen = []
    jax.jit(lambda scenario: seen.append(repr(scenario)))(jb.Scenario())
    assert "Tracer" in seen[0]


@pytest.fixture(scope="module")
def drop():
    return jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)


def test_impacts_show_those_that_happened(drop):
    lines = repr(drop.impacts).splitlines()
    assert lines[0] == "1 impact" and "approach_speed [m/s]" in lines[2]
    assert lines[-1].split()[:4] == ["1", "0", "0.211444", "2.38944"] and len(lines) == 5
    assert drop.impacts._repr_html_().count("<tr>") == 2


def test_a_run_in_a_notebook_has_the_numbers_of_its_text(drop):
    made = drop._repr_html_()
    for line in repr(drop).splitlines()[1:]:
        assert all(word in made for word in line.split()[:3]), line


def test_words_are_escaped():
    odd = table("a < b", left=("<x>",))
    odd.add_row("1 & 2")
    assert "a &lt; b" in html(odd) and '<th style="text-align:left">&lt;x&gt;</th>' in html(odd)
    assert "1 &amp; 2" in html(odd) and html("x < y") == "<pre>x &lt; y</pre>"
    assert "<td colspan" in summary_html("title\n  one cell only") and "<caption" in summary_html("title\n  a  b")
