# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A discrepancy without a name: which component lacks what, as a function of what.

A tabulated term (model/discrepancy) is tried in every component over the variables that a missing
effect there would depend on. Its values enter nearly linearly, so one simulation per knot and one
linear solve, with the declared parameters reacting, tell what each term can reach. What follows a
change, or a play, is tried with a few times of memory, or widths.
"""

from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Array, Experiment, Initial
from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import Free, put
from booster_ros.model import discrepancy as term
from booster_ros.model.catalogue import Knob
from booster_ros.model.discrepancy import KNOTS, Discrepancy
from booster_ros.model.ep_converter import QUICKEST, SLOWEST, times_as_slow
from booster_ros.model.scaling import PAPER, proportion
from booster_ros.model.system import PositionerParameters
from booster_ros.model.term_course import followed
from booster_ros.numerics.least_squares import straight
from booster_ros.records.holding import bridged

# For each component, a size of a term that a record shows, and what the term may depend on, the
# commoner kind first: chambers leak more often than a relay's forces depend on what is behind it.
_TERMS: tuple[tuple[int, float, tuple[int, ...]], ...] = (
    (term.EP_CONVERTER, 1e3, (term.CONTROL_CURRENT, term.CURRENT_CHANGE, term.TIME)),
    (term.EP_CONVERTER_LAG, 1.0, (term.BACK_PRESSURE_ERROR,)),
    (term.BOOSTER, 0.01, (term.BOOSTER_FORCE,)),
    (term.BOOSTER, 0.002, (term.FORCE_PLAY,)),
    (term.SUPPLY, 1e3, (term.TIME,)),
    (term.CHAMBER, 2e-5, (term.CHAMBER_PRESSURE, term.VALVE_POSITION, term.STEM_VELOCITY,
                          term.PRESSURE_CHANGE)),
    (term.BOOSTER, 0.01, (term.CHAMBER_PRESSURE,)),
    (term.CHAMBER_VOLUME, 2e-5, (term.VALVE_POSITION, term.CHAMBER_PRESSURE)),
    (term.STEM, 200.0,
     (term.VALVE_POSITION, term.STEM_VELOCITY, term.CHAMBER_PRESSURE, term.POSITION_CHANGE,
      term.TIME)),
    (term.PRESSURE_SENSOR, 1e3, (term.CHAMBER_PRESSURE, term.TIME)),
    (term.POSITION_SENSOR, 1e-4, (term.VALVE_POSITION, term.TIME)),
)

TIMES_OF_MEMORY = (0.4, 3.0, 12.0, 48.0)
"""Times of memory that are tried of a term over a change, s."""

REACHES = (0.003, 0.01, 0.03)
"""Half-widths that are tried of a play of the booster's force, N, in the paper's booster."""

WIDER = 10.0
"""How many times as short or long as those tried a fitted memory or half-width may be."""

ROUNDING = 1e-6
"""Share of a variable that hardly changes, by which knots are apart at the least."""

UNNAMED = 'unknown: '
"""Prefix of the label of a term, where models are listed by their effects."""

_PLACES = {
    'pressure_sensor': 'sensor', 'position_sensor': 'sensor', 'chamber_volume': 'chamber',
    'ep_converter_lag': 'ep_converter'}
"""Locations as reports print them, where they differ from the table's."""

MUCH_SLOWER = times_as_slow(-QUICKEST)
"""How many times as slow a converter may be, for how far its back pressure has to go: about ten."""

CROWDED = 4.0
"""Power with which knots about zero lie further apart the further off they are."""


@dataclass(frozen=True)
class Term:
    """Where a discrepancy may be, a size that shows, its past: memory, s, or reach of a play, N."""

    location: int
    variable: int
    size: float
    past: Knob | None = None

    @property
    def label(self) -> str:
        """Return 'component over variable'."""
        return label_of(self.location, self.variable)


def label_of(location: int, variable: int) -> str:
    """Return 'component over variable' of a term, by its numbers in a table."""
    return f'{term.LOCATIONS[location]} over {term.VARIABLES[variable]}'


def place_of(location: int) -> str:
    """Return the location of a term, by its number in a table, as effects and reports have it."""
    name = term.LOCATIONS[location]
    return _PLACES.get(name, name)


def terms(channels: tuple[str, ...], declared: PositionerParameters = PAPER) -> list[Term]:
    """Return the terms worth trying in such a valve, with these compared channels."""
    read = {term.PRESSURE_SENSOR: 'chamber_pressure', term.POSITION_SENSOR: 'valve_position',
            term.STEM: 'valve_position'}
    return [one for location, size, variables in _TERMS
            for variable in variables if location not in read or read[location] in channels
            for one in _with_pasts(
                Term(location, variable, size * _larger(declared, location)),
                _larger(declared, term.BOOSTER))]


def _larger(declared: PositionerParameters, location: int) -> float:
    """Return how many times as large a term in this location is in a valve as in the paper's."""
    return proportion(declared, term.LOCATIONS[location], term.LOCATION_UNITS[location])


def _with_pasts(one: Term, larger: float) -> list[Term]:
    """Return the term with each past that is tried; itself where it has none."""
    name, tried = 'memory', [*TIMES_OF_MEMORY]
    if one.variable == term.FORCE_PLAY:
        name, tried = 'reach', [larger * reach for reach in REACHES]
    elif one.variable not in term.CHANGE_OF:
        return [one]
    return [replace(one, past=Knob(
        f'discrepancy.{name}', each, min(tried) / WIDER, WIDER * max(tried), each, shape=True))
            for each in tried]


def with_term(problem: Problem, reference: Fit, one: Term) -> Problem:
    """
    Return the problem with the table's inner values and its past free, over the range in its rows.

    The range is that of the variable as measured, where it can be, and for a play that of the play.
    As a sensor may have reached its end, for its terms that of the parameters as given counts too.
    The table is zero beyond its range.
    """
    p, past = problem.base._replace(discrepancy=Discrepancy(one.location, one.variable)), []
    if one.past is not None:
        begin = one.past.typical
        p, past = put(p, one.past.parameter, begin), [Free(one.past, begin, begin)]
    low, high = -1.0, 1.0
    if one.variable != term.FORCE_PLAY:
        low, high = _range_followed(problem, reference, p.discrepancy)
    spread, least, most = _evenly, -1e3 * one.size, 1e3 * one.size
    if one.location == term.EP_CONVERTER_LAG:
        spread, least, most = _about_zero, QUICKEST, SLOWEST
    table = p.discrepancy._replace(knots=tuple(spread(low, high).tolist()))
    knob = Knob('discrepancy.values', one.size, least, most)
    # a prior of a size that shows keeps unseen knots near zero, and leaves what stays the same
    # everywhere to the declared parameters, which hold beyond the table too
    values = [Free(knob, 0.0, one.size, 1.0, element) for element in range(1, KNOTS - 1)]
    return replace(problem, base=problem.base._replace(discrepancy=table),
                   freedoms=(*problem.freedoms, *values, *past))


def _evenly(low: float, high: float) -> Array:
    """Return knots at equal distances, shape (KNOTS,), the inner ones from `low` to `high`."""
    spacing = max((high - low) / (KNOTS - 3), ROUNDING * max(abs(low), abs(high)), 1e-12)
    return low + spacing * np.arange(-1.0, KNOTS - 1)


def _about_zero(low: float, high: float) -> Array:
    """
    Return knots that are dense about zero, shape (KNOTS,), as many below it as above.

    Most rows have little of an error, and rising and falling differ from zero on.
    """
    shares = (np.arange(1.0, KNOTS // 2 + 1) / (KNOTS // 2 - 1))**CROWDED
    return max(-low, high, 1.0) * np.r_[-shares[::-1], shares]


def with_gentle_ends(problem: Problem, fit: Fit) -> Problem:
    """
    Return the problem with a table that fades to zero no more steeply than it runs as fitted.

    No fade is longer than the range seen; beyond a play there is nothing.
    """
    table = fit.parameters.discrepancy
    if term.has_play(table):
        return problem
    knots, inner = np.array(table.knots[1:-1]), np.array(table.values[1:-1])
    steepest = max(float(np.abs(np.diff(inner) / np.diff(knots)).max()), 1e-300)
    covers = knots[-1] - knots[0]
    below, above = np.clip(np.abs(inner[[0, -1]]) / steepest, covers / (KNOTS - 3), covers)
    table = problem.base.discrepancy._replace(knots=tuple(
        np.r_[knots[0] - below, knots, knots[-1] + above].tolist()))
    return replace(problem, base=problem.base._replace(discrepancy=table))


def linear_reach(problem: Problem, reference: Fit, one: Term) -> tuple[float, Problem, Array]:
    """
    Return what a term can reach by linear reckoning.

    That is the cost, infinite where nothing shows, its problem, and the Jacobian at a table of 0.
    """
    joint = with_term(problem, reference, one)
    where, end = len(problem.freedoms), len(joint.freedoms)
    z = np.concatenate([reference.z[:where], np.zeros(end - where), reference.z[where:]])
    r = joint.residuals(z)
    data, inner = problem.observed, range(where, where + KNOTS - 2)
    jacobian = np.zeros((len(r), len(z)))  # a past has no slope while the table has none
    jacobian[:data, np.r_[:where, end:len(z)]] = reference.jacobian[:data]
    jacobian[data:, joint.known] = np.diag(1.0 / joint.sigma[joint.known])
    longest = np.full(len(z), joint.observation.steps.most)  # beside it a table bends nowhere
    jacobian[:, inner] = joint.differences(z, r, inner, longest)
    low, high = joint.bounds()
    move = straight(*np.linalg.qr(jacobian), r, (low - z, high - z))
    left = r + jacobian @ move
    shows = jacobian[:data, inner].any()  # nothing does of what lies above a measured drive
    return float(left @ left) if shows else np.inf, joint, jacobian


def beyond(seen: tuple[float, float], experiment: Experiment, p: PositionerParameters,
           initial: Initial) -> Array:
    """Tell of each row, shape (n,), whether a run takes the variable of its term beyond `seen`."""
    run = experiment.simulate(p, initial)
    course = followed(p, experiment.time, run.columns, initial.departure.past)
    return (course < seen[0]) | (course > seen[1])


def _range_followed(problem: Problem, reference: Fit, table: Discrepancy) -> Array:
    """Return the lowest and the highest value of a term's variable in the rows of the problem."""
    values = _course(problem, reference, table)[problem.rows]
    if table.location in (term.PRESSURE_SENSOR, term.POSITION_SENSOR):
        given = problem.parameters(problem.start())
        run = problem.experiment.simulate(given, reference.initial)
        read = followed(given._replace(discrepancy=table), run['time'], run.columns)
        values = np.r_[values, read[problem.rows]]
    return np.array([np.nanmin(values), np.nanmax(values)])


def _course(problem: Problem, reference: Fit, table: Discrepancy) -> Array:
    """
    Return the variable of a term as measured, or as simulated where no row that counts has it.

    What changes runs straight across a gap. How far the back pressure has to go is no reading: it
    is that of a converter MUCH_SLOWER, as on a ramp it grows with the lag that is to be found.
    """
    experiment, p = problem.experiment, reference.parameters._replace(discrepancy=table)
    if table.variable == term.BACK_PRESSURE_ERROR:
        p = put(p, 'ep_converter.time_constant', MUCH_SLOWER * p.ep_converter.time_constant)
        # the start of a fit without the term may have gone far to imitate it
        return followed(p, experiment.time, experiment.simulate(p).columns)
    name = term.VARIABLES[term.CHANGE_OF.get(table.variable, table.variable)]
    values = experiment.measured.get(name)
    if values is None or not np.isfinite(values[problem.rows]).any():
        values = experiment.simulate(reference.parameters, reference.initial)[name]
    elif table.variable in term.CHANGE_OF:
        values = bridged(experiment.time, values)
    return followed(p, experiment.time, {name: np.asarray(values)})
