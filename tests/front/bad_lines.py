"""Command lines that can't be used, and what is said of them."""

from bad_inputs import line

FORTY = "\n".join(f"[[scenarios]]\napproach_speed = {0.1 + k / 400}" for k in range(40))
MATCHING = "[problem.variables]\nbuffer.k_A = [100, 2000]\n"

LINES = [
    line("simulate --scenario.misalignment=-4", 'allowed: (-1.5708, 1.5708) rad; "-4 deg" if that is meant'),
    line("simulate --scenario.misalignment -4 deg", "deg: no such file", 'needs quotes: "-4 deg"'),
    line("simulate study.toml 4 deg", "Got unexpected extra argument", 'needs quotes: "-4 deg"'),
    line("simulate studdy.toml", "studdy.toml: no such file; did you mean study.toml?"),
    line("simulate mine.toml", "mine.toml: no such file; jaxbuffer init mine.toml writes one to begin with"),
    # options
    line("simulate --rtol abc", "--rtol: 'abc' is not a number; expected [1e-13, 0.01]"),
    line("simulate --rtol 1", "--rtol = 1 is out of range; allowed: [1e-13, 0.01]"),
    line("sensitivity --rtol nan", "--rtol = nan is out of range; allowed: [1e-13, 0.01]"),
    line("sweep --duration 0", "--duration = 0 s is out of range; allowed: (0, inf) s"),
    line("tune --duration ages", "--duration: 'ages' is not a number; expected (0, inf) s"),
    line("simulate --solver newton", "options.solver = 'newton' is unknown; choose one of automatic, implicit"),
    line(
        "simulate --solver diffrax:Kvarno5",
        "options.solver = 'diffrax:Kvarno5' is unknown",
        "diffrax:Tsit5; did you mean diffrax:Kvaerno5?",
    ),
    line("tune --solver implicit", "No such option", "--solver"),
    line("tune --iterations few", "--iterations = 'few' must be a whole number of at least 1"),
    line("tune --iterations 0", "--iterations = 0 must be a whole number of at least 1"),
    line("tune --starts 1.5", "--starts = 1.5 must be a whole number of at least 1"),
    line("tune --seed -1", "--seed = -1 must be a whole number of at least 0"),
    line("simulate --outptu x", "No such option", "--outptu"),
    line("simulated", "No such command", "simulated"),
    line("simulate --rtol", "--rtol", "requires an argument"),
    line("simulate a.toml b.toml", "unexpected extra argument", "b.toml"),
    line(["simulate", ""], "an argument is empty"),
    line("laws --mass heavy", "--mass: 'heavy' is not a number; expected (0, inf) kg"),
    line("laws --speed 0", "--speed = 0 m/s is out of range; allowed: (0, inf) m/s"),
    # folders
    line(["simulate", "--output", ""], "--output is empty; give it a value or leave it out"),
    line("sweep --output=", "--output is empty; give it a value or leave it out"),
    line(["reproduce", "--output", ""], "--output is empty"),
    line("simulate --output study.toml", "study.toml is a file; --output needs a folder"),
    line("simulate --output study.toml/below", "study.toml is a file; --output needs a folder"),
    line("report nowhere", "nowhere: no such folder"),
    line("report .", "holds no results of simulate, sensitivity, sweep, tune, sample or pareto"),
    # fields
    line("simulate --buffer.k_A", "buffer.k_A needs a value: --buffer.k_A VALUE"),
    line("simulate --buffer.kA 1", "buffer.kA is unknown; did you mean buffer.k_A?"),
    line("simulate --bufer.k_A 1", "bufer.k_A is unknown; did you mean buffer.k_A?"),
    line("simulate --options.rtol 1", "options.rtol is unknown"),
    line("simulate --buffer.k_A=5N/q", "buffer.k_A = '5N/q': the unit q is unknown", "(0, inf) N/m"),
    line("simulate --buffer.k_A=1e999", "buffer.k_A = inf N/m is out of range; allowed: (0, inf) N/m"),
    line("simulate --probe.free_tip=yes", "probe.free_tip = 'yes' must be true or false"),
    line(
        "simulate --probe.tip_radius 0.035 --scenario.contact_distance 0.01",
        "scenario.contact_distance = 0.01 m is out of range; allowed: (0.0137868, 0.0735] m",
    ),
    line(
        "sweep --probe.tip_radius 0.035 --over scenario.contact_distance=0.01:0.05:5",
        "scenario.contact_distance = 0.01 m is out of range; allowed: (0.0137868, 0.0735] m",
    ),
    # twice
    line("simulate --buffer.k_A 1 --buffer.k_A 2", "--buffer.k_A is given twice, as 1 and as 2; keep one"),
    line("simulate --rtol 1e-6 --rtol 1e-7", "--rtol is given twice; keep one"),
    line("simulate --output a --output=b", "--output is given twice; keep one"),
    line("sweep --over buffer.k_A=1,2 --over buffer.k_A=3", "--over buffer.k_A is given more than once"),
    line("sweep --over buffer.k_A=1,2 --buffer.k_A 5", "--buffer.k_A 5 and the values of buffer.k_A", "contradict"),
    line("sweep --scenario.approach_speed 0.2", "--scenario.approach_speed 0.2 and the values of", "contradict"),
    line("sweep study.toml --buffer.k_A 5", "contradict; keep one", study="[sweep]\nbuffer.k_A = [1, 2]"),
    line(
        "tune study.toml --scenario.approach_speed 0.3",
        "--scenario.approach_speed 0.3",
        "in [problem.grid] contradict",
        study=MATCHING + "[problem.grid]\napproach_speed = [0.1, 0.2]",
    ),
    line("sensitivity --wrt buffer.k_A --wrt buffer.k_A", "wrt names buffer.k_A twice"),
    line("sensitivity --of stroke --of stroke", "quantities names stroke twice"),
    # names to differentiate
    line("sensitivity --of strok", "quantity strok is unknown; did you mean stroke?"),
    line("sensitivity --of fizz", "quantity fizz is unknown; known: peak_force, peak_time, peak_hinge_force"),
    line("sensitivity --of impact.0.time", "'0' is not an impact's number; they count from 1"),
    line("sensitivity --of impact.1.fizz", "impact.1.fizz is unknown; an impact has peak_force, approach_speed"),
    line("sensitivity --certify ful", "certify = 'ful' is unknown; choose one of quick, thorough, none"),
    line("sensitivity --wrt buffer.kA", "buffer.kA is unknown; did you mean buffer.k_A?"),
    line("sensitivity --wrt buffer", "buffer is a section; name one of its fields"),
    line("sensitivity --wrt buffer.damping", "buffer.damping = 'physical' is not a number"),
    # which scenario
    line("simulate study.toml --scenario-number 41", "--scenario-number 41", "from 1 to 40", study=FORTY),
    line("sensitivity study.toml --scenario-number 0", "--scenario-number 0", "from 1 to 40", study=FORTY),
    line("simulate --scenario-number first", "--scenario-number first must be a whole number from 1 to 1"),
    # grids
    line("sweep --over buffer.k_A", "--over buffer.k_A: expected FIELD=FROM:TO:COUNT[:log] or FIELD=VALUE"),
    line("sweep --over =1,2", "--over =1,2: expected FIELD=FROM:TO:COUNT[:log]"),
    line("sweep --over buffer.k_A=1:2", "--over buffer.k_A=1:2: expected buffer.k_A=FROM:TO:COUNT"),
    line(
        ["sweep", "--over", "scenario.approach_speed=5:20 cm/s:7"],
        'approach_speed=5:20 cm/s:7: 5 has no unit; give both ends one, or none: --over "scenario',
        "=5 cm/s:20 cm/s:7",
    ),
    line(["sweep", "--over", "buffer.k_A=1 N/m:2:3:log"], "2 has no unit", "k_A=1 N/m:2 N/m:3:log"),
    line("sweep --over buffer.k_A=1:2:0", "count = 0", "must be a whole number of at least 1"),
    line("sweep --over buffer.k_A=1:2:3:cubic", "scale = 'cubic' is unknown; choose one of linear, log"),
    line("sweep --over buffer.k_A=1,,2", "sweep.buffer.k_A: '' is not a number"),
    line("sweep --over buffer.k_A=0:2:3", "buffer.k_A = 0 N/m is out of range; allowed: (0, inf) N/m"),
    line("sweep --over fizz=1,2", "sweep: fizz is unknown; known: active, passive, buffer"),
    line("sweep --over buffer.k_A=1:2:1e9 --over buffer.c_A=1:2:1e9", "1e+18 runs", "of memory"),
]
