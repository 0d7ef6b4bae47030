# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a fit may turn: declared parameters within their priors, and parameters of effects."""

from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.model.catalogue import EFFECTS, Effect, Knob
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.scaling import PAPER, in_proportion
from booster_ros.model.system import PositionerParameters
from booster_ros.numerics.least_squares import NO_STEP


@dataclass(frozen=True)
class Free:
    """
    A parameter that a fit turns: value = knob.from_fit(centre + scale · z).

    `sigma` is the standard deviation of the prior in units of `scale`, infinite for none.
    """

    knob: Knob
    centre: float
    scale: float
    sigma: float = float('inf')
    element: int | None = None

    @property
    def low(self) -> float:
        """Lower bound of z."""
        return (min(self._ends()) - self.centre) / self.scale

    @property
    def high(self) -> float:
        """Upper bound of z."""
        return (max(self._ends()) - self.centre) / self.scale

    def _ends(self) -> tuple[float, float]:
        if self.knob.inverse:
            return self.knob.to_fit(self.knob.neutral), self.knob.to_fit(self.knob.low)
        return self.knob.low, self.knob.high

    def value(self, z: float) -> float:
        """Return the parameter's value in SI."""
        return self.knob.from_fit(self.centre + self.scale * z)

    def variable(self, value: float) -> float:
        """Return z for a value."""
        return (self.knob.to_fit(value) - self.centre) / self.scale

    @property
    def as_given(self) -> bool:
        """Whether it is a declared parameter, z = 0 where it is as given, and no effect's."""
        declared = np.isfinite(self.sigma) and not self.knob.parameter.startswith('discrepancy.')
        return bool(declared) or self.knob.parameter in BENCH

    @property
    def of_effect(self) -> bool:
        """Whether it is a size or shape of an effect, of which nothing is known beforehand."""
        return not self.as_given and not np.isfinite(self.sigma)

    def prior_deviation(self, z: float) -> float:
        """
        Return the standard deviation of z before anything is seen, for the evidence at z.

        A size of an effect is of the order of its typical size, or larger with the tail of a Cauchy
        distribution, a shape so about its typical value, both within their range. It is that of
        the Gaussian with the same density at z.
        """
        if np.isfinite(self.sigma):
            return self.sigma
        away = z - self.without_size
        return float(min(np.pi * (1.0 + away**2), self.high - self.low) / np.sqrt(2.0 * np.pi))

    @property
    def spread(self) -> float | None:
        """Standard deviation of the prior in SI, to first order; None where there is none."""
        if not np.isfinite(self.sigma):
            return None
        power = self.knob.inverse
        slope = self.value(0.0)**(power + 1) / power if power else 1.0
        return self.sigma * self.scale * slope

    def away(self, z: float) -> float:
        """Return how many standard deviations of its prior z is off, + for a larger value."""
        return (-z if self.knob.inverse else z) / self.sigma

    @property
    def without_size(self) -> float:
        """Where z stands while the effect has no size: a size at neutral, a shape at typical."""
        if self.knob.shape:
            return self.variable(self.knob.typical)
        return 0.0 if self.knob.inverse else self.variable(self.knob.neutral)


def label(free: Free) -> str:
    """Return the dotted name of what a fit turns, with the element of a list."""
    name = free.knob.parameter
    return name if free.element is None else f'{name}[{free.element}]'


def put(p: PositionerParameters, name: str, value: float, element: int | None = None
        ) -> PositionerParameters:
    """Return the parameters with one of them, by its dotted name, changed."""
    component, attribute = name.split('.')
    content = getattr(p, component)
    if element is None:
        return p._replace(**{component: content._replace(**{attribute: value})})
    elements = list(getattr(content, attribute))
    elements[element] = value
    return p._replace(**{component: content._replace(**{attribute: tuple(elements)})})


def get(p: PositionerParameters, name: str, element: int | None = None) -> float:
    """Return a parameter by its dotted name, one element of it where it is a list."""
    component, attribute = name.split('.')
    value = getattr(getattr(p, component), attribute)
    return float(value if element is None else value[element])


def possible_departures(p: PositionerParameters) -> set[str]:
    """Return what may be off at the start by the sizes of effects, as fields of `Departure`."""
    return {knob.departs for effect in EFFECTS.values() for knob in effect.knobs
            if knob.departs and get(p, knob.parameter) > 0.0}


# Relative and absolute (SI) spread within which a declared parameter may be off, and element of a
# list; the bounds lie at five times the spread. What only scales speed is wider on purpose.
_DECLARED: tuple[tuple[str, float, float, int | None], ...] = (
    ('ep_converter.gain', 0.02, 0.0, None),
    ('ep_converter.offset', 0.0, 2e3, None),
    ('ep_converter.time_constant', 0.15, 0.0, None),
    ('booster.opening_gain', 0.06, 0.0, None),
    ('booster.max_area', 0.06, 0.0, None),
    ('booster.critical_pressure_ratio', 0.03, 0.0, None),
    ('supply.pressure', 0.015, 0.0, None),
    ('actuator.dead_volume', 0.06, 0.0, None),
    ('actuator.bench_set', 0.004, 0.0, 0),
    ('actuator.bench_set', 0.004, 0.0, 1),
    ('actuator.viscous_friction', 0.3, 0.0, None),
    ('actuator.stop_stiffness', 0.3, 0.0, None),
    ('position_controller.gain', 0.1, 0.0, None),
    ('position_controller.integral_time', 0.1, 0.0, None),
)


TOLD_AT_REST = frozenset((
    'ep_converter.gain', 'ep_converter.offset', 'supply.pressure', 'actuator.bench_set',
    'actuator.stop_stiffness'))
"""Declared parameters that settled pressures and positions depend on."""

OF_THE_CHAMBER = frozenset(('actuator.dead_volume',))
"""Declared parameters of the actuator that belong to its chamber; the others, to its stem."""

BENCH = ('booster.opening_gain', 'booster.max_area')
"""What a flow bench is there to measure: beside its flows nothing known of these two counts."""

BENCH_RANGE = 20.0
"""Factor by which the bench may find these two off what was declared, up or down."""

SOFTEST_STOP, HARDEST_STOP = 0.4, 10.0
"""Bounds of the stiffness of the stops, as shares of the declared one: softer stops are soft seats,
and no sensor sees harder ones yield."""


def declared_freedom(p: PositionerParameters, experiment: Experiment) -> list[Free]:
    """Return the declared parameters that a refit may turn, with their priors."""
    found = []
    for name, relative, absolute, element in _DECLARED:
        value = get(p, name, element)
        if name in BENCH and experiment.is_flow_bench:
            # as inverses: a flow force adds to the stiffness against opening
            high = value * BENCH_RANGE
            knob = Knob(name, value, value / BENCH_RANGE, high, high, inverse=1)
            found.append(Free(knob, 1.0 / value, 1.0 / value))
            continue
        if name == 'actuator.stop_stiffness':  # as a compliance: a record may show next to none
            hard = min(HARDEST_STOP * value, DESCRIPTIONS[name].high)
            knob = Knob(name, value, SOFTEST_STOP * value, hard, hard, inverse=1)
            found.append(Free(knob, 1.0 / value, relative / value, 1.0))
            continue
        width = abs(value)
        if name == 'actuator.bench_set':  # one end is known as well as the span between both
            width = max(width, float(np.ptp(p.actuator.bench_set)))
        spread = absolute + relative * width
        if spread <= 0.0:
            continue
        signed = absolute or name == 'actuator.bench_set'
        low = max(value - 5.0 * spread, -np.inf if signed else 0.05 * value)
        found.append(Free(
            Knob(name, value, low, value + 5.0 * spread, value), value, spread, 1.0, element))
    return found


LOOSENED = 3.0
"""Factor by which a declared parameter's prior and bounds widen beside an effect that says so."""


def loosened(free: Free, effect: Effect) -> Free:
    """Return a freedom as it is beside an effect: wider if the effect makes it less well known."""
    knob = free.knob
    if knob.parameter not in effect.loosens or not np.isfinite(free.sigma):
        return free
    low, high = (free.centre + LOOSENED * (end - free.centre) for end in (knob.low, knob.high))
    described = DESCRIPTIONS[knob.parameter]
    return replace(free, sigma=LOOSENED * free.sigma, knob=replace(
        knob, low=max(low, described.low), high=min(high, described.high)))


def about(free: Free, value: float) -> Free:
    """Return a freedom about another value, as wide in proportion; about none it stays there."""
    larger, knob = value / free.centre, free.knob
    if not larger:
        return replace(free, centre=0.0, knob=replace(
            knob, typical=0.0, low=-NO_STEP * free.scale, high=0.0))
    return replace(free, centre=value, scale=larger * free.scale, knob=replace(
        knob, typical=larger * knob.typical, low=larger * knob.low, high=larger * knob.high))


def effect_freedom(effect: Effect, declared: PositionerParameters = PAPER) -> list[Free]:
    """Return the parameters of an effect in such a valve, neutral at z = 0, typical near z = 1."""
    found = []
    for knob in (in_proportion(one, declared) for one in effect.knobs):
        neutral = 0.0 if knob.inverse else knob.neutral
        scale = knob.to_fit(knob.typical) - neutral
        if scale == 0.0 or knob.shape:
            scale = knob.to_fit(knob.typical) or 1.0
        found.append(Free(knob, neutral, abs(scale)))
    return found
