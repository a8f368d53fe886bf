"""`make test` has a test of every file but those whose claims take whole runs, which others have in short."""

OF_WHOLE_RUNS = {
    # other programs and other processes
    *("benchmarks/test_peers.py", "cluster/test_distributed_certificate.py", "cluster/test_distributed_front.py"),
    *("cluster/test_faults.py", "cli/test_lost_work_kills.py", "cli/test_lost_work_tank.py"),
    *("pages/test_report_browser.py", "pages/test_what_if_browser.py", "documents/test_pages.py"),
    *(
        f"verification/test_second_opinion{it}.py"
        for it in ("", "_docking", "_drop", "_plate", "_slider_crank", "_space", "_tank")
    ),
    # many designs, choices and fits
    *("choosing/test_worst_corners.py", "docking/test_similar_mechanisms.py", "elements/test_without_contacts.py"),
    *(f"fitting/test_{it}.py" for it in ("damaged", "measured", "sensors", "signals")),
    *("sensitivities/test_unused_fields.py", "tuning/test_tuned_docking.py"),
    "tuning/test_captures.py",
    # structures of a mechanism that no other quick test compiles
    *(f"mechanisms/test_{it}.py" for it in ("bottomed_words", "diagnosis", "full_tank", "other_laws", "struck_beam")),
    *("mechanisms/test_tank_drop_gradients.py", "mechanisms/test_tank_plates.py", "structures/test_hertz.py"),
    *(f"multibody/test_flexible_{it}.py" for it in ("examples", "spin_up")),
    # the docking in space, whose programs take half a minute each; its start and what is said of it are quick
    *(f"docking3d/test_docking3d_{it}.py" for it in ("diffrax", "files", "instant", "runs", "studies", "transforms")),
    "properties/test_invariants.py",
    *(f"verification/test_{it}.py" for it in ("batched_captures", "buffer_end", "diffrax_route", "docking")),
    *(f"verification/test_{it}.py" for it in ("elasticities", "exact", "gradients", "hard_cases", "located_maxima")),
    *(f"verification/test_{it}.py" for it in ("papers_form", "regularisation", "rigid_probe", "smooth_law")),
}


def test_every_other_file_has_a_quick_test(files_without_quick):
    left_out = files_without_quick - OF_WHOLE_RUNS
    assert not left_out, "mark a test of each, that takes no whole run, with pytest.mark.quick"
