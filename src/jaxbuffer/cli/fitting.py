"""The command fit, as its help shows it."""


def fit() -> None:
    r"""Fit the numbers in [fit.parameters] to the measured tests in [[fit.tests]], all together.

    The search begins at the design's own numbers, with the first rows of the records, and goes on with more and more of
    them. Each number has a 95 % interval; what the data cannot tell apart is said (docs/fit.md). Residuals above three
    deviations of the noise do not explain a test: exit code 1.

    \b
    In CONFIG.toml:
      [fit.parameters]                       # bounds
      buffer.k_A = ["100 N/m", "3 kN/m"]
      [[fit.tests]]
      file = "test-01.csv"                   # beside CONFIG.toml
      time = "time [s]"
      scenario.approach_speed = 0.13         # m/s, this test's own
      time_shift = ["0 ms", "30 ms"]         # unknown; or a number
      [fit.tests.columns]
      "stroke [mm]" = {quantity = "stroke", noise = "0.02 mm"}

    \b
    Files in DIR:
      design.toml  the fitted design, a study for the other commands
      fit.json     numbers with their intervals, sensors, residuals, correlation
      fit.csv      what was measured and what the fitted design gives, row by row, of each test
      fit.png      the same, and the residuals over the noise
      fit.txt      the tables

    \b
    Example: jaxbuffer fit study.toml --output fitted
    """
