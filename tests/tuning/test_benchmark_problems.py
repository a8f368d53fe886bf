"""The six problems of ``python -m benchmarks problems`` are what docs/tuning.md says, and a small one is solved."""

import numpy as np
import pytest

from benchmarks import problems
from jaxbuffer.study.load import load


@pytest.mark.parametrize("name", problems.BEST)
def test_every_problem_reads_and_has_a_best_known(name):
    stated = load(problems.FOLDER / f"{name}.toml").problem()
    assert 6 <= len(stated.cases) <= 40 and len(stated.variables) >= 4
    assert np.isfinite(problems.BEST[name])
    assert {file.stem for file in problems.FOLDER.glob("*.toml")} == set(problems.BEST)


def test_a_run_above_the_best_known_fails_the_benchmark(monkeypatch, tmp_path, capsys):
    """Made-up runs: one 0.5 %, one 2 % above."""

    def made_up(name, seed):
        above = (0.005, 0.02)[seed]
        found = problems.BEST[name] * (1.0 + above)
        return {"problem": name, "scenarios": 6, "seed": seed, "captures": 10, "screened": 5, "objective [N]": found,
                "above_best [-]": above, "message": "made up"}  # fmt: skip

    monkeypatch.setattr(problems, "ran", made_up)
    file = tmp_path / "out" / "problems.json"
    assert problems.main(only="small", output=file) == 0
    assert "worst: 0.50 % above the best known" in capsys.readouterr().out
    assert problems.main(only="small", seeds=2, output=file) == 1
    assert "worst: 2.00 % above" in capsys.readouterr().out


@pytest.mark.long
def test_the_small_problem_is_solved_by_default():
    """Within 1 % of the best known of several seeds; the old default ended at 374.03 N."""
    row = problems.ran("small", 0)
    assert row["above_best [-]"] < problems.WORST, row
