"""Every test runs in double precision and with strict rank promotion, and may leave evidence for the report.

Compiled programs, which take most of the time, are kept in one folder for all processes of a test run. Those in memory
are dropped between files where a process holds too much.

`make test` runs what has none of the markers `slow`, `whole` and `long`, `make test-slow` what is slow or whole and not
long, `make test-long` what is long.
"""

import ctypes
import gc
import os
import shutil
import tempfile
from pathlib import Path

import pytest

import jaxbuffer.cli.quick
import jaxbuffer.programs.process

jaxbuffer.cli.quick.prepare()
jaxbuffer.programs.process.configure()

import jax  # noqa: E402

from evidence import Evidence  # noqa: E402
from jaxbuffer.programs.cache import stored  # noqa: E402
from jaxbuffer.programs.store import store_in  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")

EVIDENCE = Evidence()
PROGRAMS = pytest.StashKey[Path]()
MOST_MEMORY = 5 * 2**30  # bytes that a process may hold at the end of a file
# Tests here solve whole runs of a mechanism, mostly one of their own: they compile large programs or start processes.
# Each may be quick by itself; all together they are too long for `make test`.
WHOLE = ("cluster/", "mechanisms/", "multibody/test_flexible_", "properties/", "verification/")
# Some tests here take minutes: begun last, one of them would keep one process busy after the other has finished.
FIRST = ("test_guides.py", "test_lost_work_kills.py", "test_lost_work_tank.py")
# Tests that took about 30 s or more each on two slow cores, unless others use the program that they compile, or nothing
# else in CI tests the same. CI leaves them out: with them it takes far more than an hour.
LONG = (
    "cluster/test_faults.py::test_a_tuning_over_a_scheduler_is_the_same",
    "contact/test_registration.py::test_a_law_is_looked_up_when_it_is_used",
    "contact/test_registration.py::test_a_law_redefined_in_another_process_is_another_program",
    "docking/test_oscillators.py::test_the_shocks_of_a_run_are_those_of_its_history",
    "front/test_cli.py::test_a_real_capture_from_another_process",
    "front/test_docking_input.py::test_folders_and_pages_have_the_curves",
    "front/test_lost_work_kills.py::test_killed_at_random_moments",  # run by `make faults` as well
    "front/test_lost_work_tank.py::test_a_tanks_study_that_was_killed_is_resumed_to_the_same_bits",
    "front/test_reproduce_crank.py::test_the_studies",
    "hybrid/test_moving.py::test_reverse_mode_meets_no_nan",
    "mechanisms/test_bar_drop.py::test_tuned_under_a_limit_on_penetration",
    "mechanisms/test_bar_drop_plate.py::test_elasticities_of_peak_and_deflection",
    "mechanisms/test_bar_drop_plate.py::test_history_figure_and_multipliers",
    "mechanisms/test_bar_drop_plate.py::test_how_many_modes_the_peak_takes",
    "mechanisms/test_bar_drop_plate.py::test_known_numbers_of_a_plate_in_eight_modes",
    "mechanisms/test_bending_probe.py::test_elasticities_of_the_first_peak",
    "mechanisms/test_bending_probe.py::test_many_stiffnesses_at_once",
    "mechanisms/test_bending_probe.py::test_stiffer_probes_tend_to_the_rigid_one",
    "mechanisms/test_bending_probe.py::test_what_a_run_shows",
    "mechanisms/test_bending_rod.py::test_a_stiff_rod_is_a_rigid_one",
    "mechanisms/test_bending_rod.py::test_energy_and_joints_with_play",
    "mechanisms/test_bottomed_words.py::test_the_cure_is_named_and_no_amount",
    "mechanisms/test_drop_angle.py::test_derivatives_by_the_angle_are_those_of_differences",
    "mechanisms/test_drop_angle.py::test_the_whole_section_does_what_its_half_says[changes2-0.001]",
    "mechanisms/test_drop_angle.py::test_the_whole_section_does_what_its_half_says[changes3-0.008]",
    "mechanisms/test_drop_angle.py::test_the_whole_section_does_what_its_half_says[changes4-0.004]",
    "mechanisms/test_drop_angle.py::test_the_whole_section_does_what_its_half_says[changes5-0.002]",
    "mechanisms/test_drop_angle.py::test_the_whole_section_does_what_its_half_says[changes6-0.002]",
    "mechanisms/test_drop_angle.py::test_the_whole_section_does_what_its_half_says[changes7-0.001]",
    "mechanisms/test_hinge_play.py::test_elasticities_of_the_first_impact",
    "mechanisms/test_hinge_play.py::test_many_plays_at_once",
    "mechanisms/test_hinge_play.py::test_the_pin_stays_in_its_bush_and_its_force_is_the_vehicles",
    "mechanisms/test_other_laws.py::test_energy_and_first_impact",
    "mechanisms/test_planar_shapes.py::test_a_slider_like_a_pile_is_squeezed_by_its_own_inertia",
    "mechanisms/test_planar_shapes.py::test_a_straight_mesh_runs_as_the_bar_does",
    "mechanisms/test_published_slider_crank.py::test_it_runs_over_a_cycle",
    "mechanisms/test_slider_crank.py::test_damping_factors_are_the_authors",
    "mechanisms/test_slider_crank.py::test_elasticities_of_independent_programs",
    "mechanisms/test_slider_crank.py::test_gradients_where_play_decides",
    "mechanisms/test_slider_crank.py::test_horizon",
    "mechanisms/test_slider_crank.py::test_many_at_once_and_under_vmap",
    "mechanisms/test_slider_crank.py::test_no_run_of_thirty_wide_designs_fails",
    "mechanisms/test_slider_crank_statistics.py::test_the_summary_has_them_and_says_what_is_missing",
    "mechanisms/test_tank_drop.py::test_three_meshes_converge",
    "mechanisms/test_tank_drop_gradients.py::test_on_a_penalty_support_derivatives_are_those_of_differences",
    "mechanisms/test_tank_plates.py::test_derivatives_by_a_plate_are_those_of_differences",
    "properties/test_transformations.py::test_a_capture_inside_an_outer_jit_is_the_same",
    "properties/test_transformations.py::test_captures_batched_over_scenarios_are_the_loop",
    "run/test_loads.py::test_the_energys_derivative",
    "shock/test_spectrum.py::test_a_tanks_slider_shakes_what_it_carries_as_its_force_says",
    "tuning/test_benchmark_problems.py::test_the_small_problem_is_solved_by_default",
    "tuning/test_bottoming.py::test_a_start_at_the_buffers_end_is_infeasible_and_slopes_lead_out_of_it",
    "tuning/test_descent.py::test_the_whole_of_it_by_diffrax",
    "tuning/test_docked.py::test_a_curve_is_tuned_until_the_vehicles_are_nearly_at_rest",
    "tuning/test_docked.py::test_derivatives_by_a_curves_points_are_those_of_differences",
    "tuning/test_starts.py::test_an_answer_survives_bounds_that_do_not_fit",
    "tuning/test_studies.py::test_the_literal_way_ends_where_the_default_one_does",
    "tuning/test_studies.py::test_the_main_study_ends_low_in_both_objectives",
    "verification/test_batched_captures.py::test_lanes_are_the_runs_alone_and_one_fails_alone",
    "verification/test_buffer_end.py::test_a_full_log_loses_nothing_but_the_list_of_impacts",
    "verification/test_buffer_end.py::test_a_yield_stress_is_held_against_the_pressure",
    "verification/test_buffer_end.py::test_derivatives_of_a_run_with_a_full_log",
    "verification/test_buffer_end.py::test_gradients_go_right_through",
    "verification/test_buffer_end.py::test_no_penetration_exceeds_the_one_told[0.3-adams]",
    "verification/test_buffer_end.py::test_the_flank_has_a_back",
    "verification/test_closed_forms.py::test_kelvin_voigt_impact_and_its_gradients_through_the_jump_of_the_force",
    "verification/test_diffrax_route.py::test_adjoints",
    "verification/test_diffrax_route.py::test_captures_are_those_of_the_loop[table2]",
    "verification/test_diffrax_route.py::test_elasticities_under_error_control",
    "verification/test_diffrax_route.py::test_implicit_methods",
    "verification/test_diffrax_route.py::test_what_follows_from_a_capture",
    "verification/test_docking.py::test_elasticities",
    "verification/test_gradients.py::test_elasticities_over_random_designs",
    "verification/test_gradients.py::test_sensitivities_stop_no_run_and_hold_none_up",
    "verification/test_hard_cases.py::test_nothing_of_a_failed_run_is_a_number",
    "verification/test_hard_cases.py::test_tangents_beside_a_touchdown_at_tight_tolerance",
    "verification/test_located_maxima.py::test_no_accepted_step_exceeds_a_maximum_of_the_campaign",
    "test_derivatives_everywhere.py::test_the_history_holds_the_largest_stroke_with_its_derivative",
    "test_documents.py::test_the_example_of_a_public_name_runs[published_slider_crank]",
    "test_effective_energy.py::test_the_references_first_peaks[free tip]",
    "test_guides.py::test_commands_of_a_guide_run[gradients.md]",
    "test_guides.py::test_commands_of_a_guide_run[laws.md]",
    "test_guides.py::test_commands_of_a_guide_run[quickstart.md]",
    "test_guides.py::test_commands_of_a_guide_run[tank_drop.md]",
    "test_guides.py::test_commands_of_a_guide_run[tuning.md]",
    "test_pages.py::test_examples_of_a_page_run[diffrax.md]",
    "test_pages.py::test_examples_of_a_page_run[gradients.md]",
    "test_pages.py::test_examples_of_a_page_run[mechanisms.md]",
    "test_pages.py::test_examples_of_a_page_run[slider_crank.md]",
    "test_pages.py::test_examples_of_a_page_run[structures.md]",
    "test_pages.py::test_examples_of_a_page_run[tank_drop.md]",
    "test_pages.py::test_examples_of_a_page_run[tuning.md]",
    "test_programs.py::test_a_stiffness_given_in_one_process_is_no_yield_stress_in_the_next",
    "test_quantities.py::test_derivatives_of_every_quantity_agree_with_differences_of_tight_solves[captured]",
    "test_traced_input.py::test_a_failed_capture_has_no_derivative",
    "test_unused_fields.py::test_a_field_that_does_nothing_alone",
    "test_unused_fields.py::test_fields_that_do_nothing_have_no_derivatives[probe_cone]",
    "test_unused_fields.py::test_fields_that_do_nothing_have_no_derivatives[slider_crank]",
)
TESTS = Path(__file__).parent


@pytest.fixture(scope="session")
def evidence():
    """Asserts a measured error and remembers it; see `Evidence`."""
    return EVIDENCE


@pytest.fixture(scope="session")
def programs(pytestconfig):
    """The folder of compiled programs."""
    return pytestconfig.stash[PROGRAMS]


@pytest.fixture(autouse=True)
def _programs_kept(programs):
    """Whatever folder the test before has chosen."""
    store_in(programs)


@pytest.fixture(scope="module", autouse=True)
def _memory_freed():
    yield
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * 4096
    if resident > MOST_MEMORY:
        jax.clear_caches()
        gc.unfreeze()  # what is frozen is in no list of objects
        for function in gc.get_objects():
            if isinstance(function, stored):
                function.programs.clear()
        gc.collect()
        # What is freed goes back to the system; else the process would seem to hold too much after every file to come,
        # and compile everything anew in each.
        ctypes.CDLL(None).malloc_trim(0)


def pytest_addoption(parser):
    parser.addoption("--kills", type=int, default=2, help="how often test_lost_work_kills kills each command")
    parser.addoption("--evidence", type=Path, help="write what tests measured to this JSON file")
    parser.addoption("--programs", type=Path, help="use and keep compiled programs of another test run in this folder")


def pytest_configure(config):
    given = getattr(config, "workerinput", {}).get("programs") or config.getoption("--programs")
    config.stash[PROGRAMS] = Path(given or tempfile.mkdtemp(prefix="jaxbuffer-programs-"))
    os.environ["JAXBUFFER_CACHE"] = str(config.stash[PROGRAMS])  # of commands, in this process and others
    jaxbuffer.programs.process.configure()


@pytest.hookimpl(tryfirst=True)  # before tests are selected by their markers
def pytest_collection_modifyitems(items):
    for item in items:
        if not item.path.is_relative_to(TESTS):
            continue
        place = item.path.relative_to(TESTS).as_posix()
        if place.startswith(WHOLE):
            item.add_marker("whole")
        if not {f"{place}::{name}" for name in (item.originalname, item.name)}.isdisjoint(LONG):
            item.add_marker("long")
    items.sort(key=lambda item: item.path.name not in FIRST)


def pytest_collection_finish():
    """Modules and tests live as long as the process: the collector need not visit them again and again."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node):
    """What pytest-xdist gives each of its processes."""
    node.workerinput["programs"] = str(node.config.stash[PROGRAMS])


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """What pytest-xdist has from each of its processes."""
    EVIDENCE.add(getattr(node, "workeroutput", {}).get("evidence", []))


def pytest_sessionfinish(session):
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["evidence"] = list(EVIDENCE.records.values())
    elif path := session.config.getoption("--evidence"):
        EVIDENCE.write(path)


def pytest_unconfigure(config):
    if not hasattr(config, "workerinput") and not config.getoption("--programs"):
        shutil.rmtree(config.stash[PROGRAMS], ignore_errors=True)
