"""What a test would have recorded: a run's histories behind the sensors, with derivatives by all unknowns."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..tuning.problem.variable import Variable
from .clipping import clipped_rows
from .low_pass import Filtered
from .recording import FILTER, GAIN, Recording, bounds, noise_of
from .residuals import Block
from .signals import Parameters, Signals, SteppedRun, signals, stepped_run

SHIFT = "time_shift"
FINE = 1e-4  # s, between the shifts that are tried first
MEDIAN = 1.4826  # of a normal distribution: its deviation over the median of sizes


class SensorModel(NamedTuple):
    """A channel as numbers: ``quantity``; ``noise`` in its unit, None if unknown; ``gain`` [-], ``offset`` in the
    quantity's unit, ``lag`` and ``delay`` [s], each a number or unknown."""

    quantity: str
    noise: float | None
    gain: float | Variable
    offset: float | Variable
    lag: float | Variable
    delay: float | Variable

    @property
    def slow(self) -> bool:
        """Return whether it records later than at once."""
        return any(isinstance(it, Variable) or it != 0.0 for it in (self.lag, self.delay))


class Prediction:
    """A test's prediction from the parameters and its own unknowns.

    **Arguments:** ``of``: the run, by the parameters' paths; ``recording``; ``units`` of the quantities, by name.

    **Raises:** `InputError` for numbers of a sensor that are out of range.
    """

    def __init__(self, of: Parameters, recording: Recording, units: Mapping[str, str]) -> None:
        self.of, self.recording, self.times, self.units = of, recording, recording.times, units
        name = recording.name
        self.shift = bounds(f"{name}: {SHIFT}", recording.time_shift, "s")
        self.sensors: dict[str, SensorModel] = {}
        for column, channel in recording.channels.items():
            where = f"{name}: {column}: "
            lag = bounds(f"{where}filter", channel.filter, "s", **FILTER)
            half = 0.5 * float(np.median(np.diff(self.times)))
            delay = channel.delay
            if delay is None:
                # Digital filters lead or lag by up to half an interval: with the delay fixed, intervals would not hold.
                delay = (-half, half) if isinstance(lag, Variable) else 0.0
            self.sensors[column] = SensorModel(
                channel.quantity,
                noise_of(f"{where}noise", channel, units[channel.quantity]),
                bounds(f"{where}gain", channel.gain, "-", **GAIN),
                bounds(f"{where}offset", channel.offset, units[channel.quantity]),
                lag,
                bounds(f"{where}delay", delay, "s"),
            )
        self.values = np.stack([np.asarray(recording.values[column], float) for column in self.sensors])
        numbers: dict[str, tuple[float | Variable, str]] = {SHIFT: (self.shift, "s")}
        for column, sensor in self.sensors.items():
            numbers[f"{column}: gain"] = sensor.gain, "-"
            numbers[f"{column}: offset"] = sensor.offset, units[sensor.quantity]
            numbers[f"{column}: filter"] = sensor.lag, "s"
            numbers[f"{column}: delay"] = sensor.delay, "s"
        self.unknowns = {name: it for name, (it, _) in numbers.items() if isinstance(it, Variable)}
        self.own_units = {name: numbers[name][1] for name in self.unknowns}
        # A sensor at the end of its range says only that the quantity is beyond it.
        self.clipped = np.stack([clipped_rows(it) for it in self.values])
        self.begin, self.end_time, self.failed = float(self.times[0]), 0.0, False

    def noise(self) -> Float[np.ndarray, " columns"]:
        """Return the deviation of each column's noise; where it is not known, that of its second differences."""
        deviations = []
        for sensor, values in zip(self.sensors.values(), self.values, strict=True):
            if sensor.noise is not None:
                deviations.append(sensor.noise)
                continue
            # Impacts are few: the median does not see them. A record without noise has the rounding of its digits.
            # The second difference of white noise has six times its variance.
            rough = MEDIAN * float(np.median(np.abs(np.diff(values, 2)))) / np.sqrt(6.0) if len(values) > 2 else 0.0
            deviations.append(max(rough, 1e-6 * float(np.max(np.abs(values))), 1e-300))
        return np.array(deviations)

    def rows(self, share: float) -> int:
        """Return how many rows a share of the record's time has."""
        until = self.begin + share * (self.times[-1] - self.begin)
        return len(self.times) if share >= 1.0 else max(int(np.searchsorted(self.times, until, side="right")), 2)

    def __call__(
        self, numbers: np.ndarray, own: Sequence[float] | np.ndarray, share: float
    ) -> tuple[Float[np.ndarray, "columns rows"], Float[np.ndarray, "columns rows unknowns"]]:
        """Return what the sensors would record up to a share of the test, and its slopes by the parameters and then by
        the test's own unknowns."""
        at = dict(zip(self.unknowns, own, strict=True))
        moments = self.times[: self.rows(share)] - self._value(SHIFT, self.shift, at)
        # A sensor with a negative delay records what the run does later, so the run must last longer.
        early = max(0.0, *(-self._value(f"{column}: delay", it.delay, at) for column, it in self.sensors.items()))
        run = stepped_run(self.of, numbers, max(float(moments[-1]) + early, 1e-6))
        self.end_time, self.failed = run.end_time, run.failed
        values, slopes, rates, lagging = self._behind_filters(run, moments, at)
        count = slopes.shape[2]
        full = np.zeros((*values.shape, count + len(self.unknowns)))
        full[..., :count] = slopes
        places = {name: count + k for k, name in enumerate(self.unknowns)}
        if SHIFT in places:
            full[..., places[SHIFT]] = -rates
        shown = self._shown(values, at)
        for k, (column, sensor) in enumerate(self.sensors.items()):
            if (place := places.get(f"{column}: filter")) is not None:
                full[k, :, place] = lagging[k]
            if (place := places.get(f"{column}: delay")) is not None:
                full[k, :, place] = -rates[k]
            full[k] *= self._value(f"{column}: gain", sensor.gain, at)
            # After the others were multiplied: the slope by the gain is the signal before it.
            if (place := places.get(f"{column}: gain")) is not None:
                full[k, :, place] = values[k]
            if (place := places.get(f"{column}: offset")) is not None:
                full[k, :, place] = 1.0
        return shown, full

    def start_shift(self, numbers: np.ndarray, noise: np.ndarray, share: float) -> float:
        """Return the time shift at which the beginning of the test fits a run with these numbers best."""
        assert isinstance(self.shift, Variable)
        low, high = self.shift.low, min(self.shift.high, float(self.times[-1]))
        until = high + share * (self.times[-1] - self.times[0])
        rows = self.times <= until
        own = [unknown.value(0.5) for unknown in self.unknowns.values()]
        at = dict(zip(self.unknowns, own, strict=True)) | {SHIFT: 0.0}
        moments = np.arange(0.0, until - low + FINE, FINE)
        run = stepped_run(self.of, numbers, float(moments[-1]))
        values = self._shown(self._behind_filters(run, moments, at)[0], at)

        def misfit(shift: float) -> float:
            found = [np.interp(self.times[rows] - shift, moments, it) for it in values]
            return float(np.sum(((np.stack(found) - self.values[:, rows]) / noise[:, None]) ** 2))

        # All are tried: an impact that comes too late meets none of the record's, and a descent would end there.
        return min(np.linspace(low, high, max(int((high - low) / FINE), 2)), key=misfit)

    def block(self, numbers: np.ndarray, own: Sequence[float] | np.ndarray, share: float, noise: np.ndarray) -> Block:
        """Return the residuals over the ``noise`` of each column."""
        values, slopes = self(numbers, own, share)
        rows = values.shape[1]
        weights = np.where(self.clipped[:, :rows], 0.0, 1.0 / noise[:, None])
        return Block((values - self.values[:, :rows]) * weights, slopes * weights[..., None])

    def _shown(self, signals: np.ndarray, at: Mapping[str, float]) -> np.ndarray:
        """Return what the sensors show of filtered signals: each times its gain, plus its offset."""
        gains = [self._value(f"{column}: gain", it.gain, at) for column, it in self.sensors.items()]
        offsets = [self._value(f"{column}: offset", it.offset, at) for column, it in self.sensors.items()]
        return signals * np.array(gains)[:, None] + np.array(offsets)[:, None]

    def _value(self, name: str, given: float | Variable, at: Mapping[str, float]) -> float:
        return at[name] if isinstance(given, Variable) else given

    def _behind_filters(
        self, run: SteppedRun, moments: np.ndarray, at: Mapping[str, float]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return values, slopes by the parameters, rates, and slopes by the filters' time constants."""
        # Sorted, because the names are a part of the compiled program's key, and a set has no order of its own.
        every = sorted({sensor.quantity for sensor in self.sensors.values()})
        nodes, place = np.zeros(0), np.arange(len(moments))
        if any(sensor.slow for sensor in self.sensors.values()):
            # The ends of steps and the rows' moments, in order, and the place of each row among them.
            nodes = np.concatenate([np.clip(moments, run.time[0], run.time[-1]), run.time])
            order = np.argsort(nodes, kind="stable")
            nodes, place = nodes[order], np.argsort(order, kind="stable")[: len(moments)]
            known = signals(self.of, run, every, np.concatenate([nodes, 0.5 * (nodes[1:] + nodes[:-1])]))
        else:
            known = signals(self.of, run, every, moments)
        parts = []
        for column, sensor in self.sensors.items():
            k = every.index(sensor.quantity)
            if sensor.slow:
                lag = self._value(f"{column}: filter", sensor.lag, at)
                delay = self._value(f"{column}: delay", sensor.delay, at)
                parts.append(_filtered(known, k, nodes, moments - delay, lag))
            else:
                # As it is: it has no slope by a time constant.
                parts.append(
                    (*(of[k][place] for of in (known.values, known.slopes, known.rates)), np.zeros(len(place)))
                )
        values, slopes, rates, lagging = (np.stack(them) for them in zip(*parts, strict=True))
        return values, slopes, rates, lagging


def _filtered(known: Signals, k: int, nodes: np.ndarray, times: np.ndarray, lag: float) -> tuple[np.ndarray, ...]:
    """Return value, slopes, rate and slope by the time constant of a signal behind a low-pass, at any times."""
    columns = np.concatenate([known.values[k][:, None], known.slopes[k]], axis=1)
    # Beyond the run's ends everything is taken to stand still: neither shift nor delay changes the record there.
    low_pass, moving = Filtered(nodes, lag), (times >= nodes[0]) & (times <= nodes[-1])
    inside = np.clip(times, nodes[0], nodes[-1])
    answer, signal, by_lag = low_pass.within(inside, columns[: len(nodes)], columns[len(nodes) :])
    rate = (signal[:, 0] - answer[:, 0]) / low_pass.lag * moving
    return answer[:, 0], answer[:, 1:], rate, by_lag[:, 0]
