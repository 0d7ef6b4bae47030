# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says: plain data, for the report, the files and the tests."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from booster_ros.diagnosis.experiment.experiment import UNITS, Experiment, Initial, rmse
from booster_ros.diagnosis.experiment.segments import Segment
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.model import discrepancy as term
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.discrepancy import Discrepancy
from booster_ros.model.system import PositionerParameters

Array = np.ndarray


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class FoundEffect:
    """
    An effect that the model lacked; `location` is where it is born.

    The experiment that separates it is the catalogue's, none where it has no name.
    """

    name: str
    location: str
    parameters: dict[str, Interval]
    confused_with: tuple[str, ...]
    separating_experiment: str
    evidence: dict[str, float]


def either(effect: FoundEffect) -> str:
    """Return a sentence where each of several sizes may be none, but not all of them, else ''."""
    if effect.name not in EFFECTS:
        return ''
    sizes = [knob for knob in EFFECTS[effect.name].knobs
             if not knob.shape and knob.parameter in effect.parameters]
    intervals = [effect.parameters[knob.parameter] for knob in sizes]
    if len(sizes) < 2 or not all(
            found.low <= knob.neutral <= found.high for knob, found in zip(sizes, intervals)):
        return ''
    return (f'{" and ".join(knob.parameter for knob in sizes)}: each may be none, but not all: '
            'this record shows what they do together, with declared parameters beside them')


@dataclass(frozen=True)
class UnknownTerm:
    """A discrepancy without a name: a table over one variable in one component, SI units."""

    table: Discrepancy

    @property
    def location(self) -> str:
        """The component that it enters."""
        return term.LOCATIONS[self.table.location]

    @property
    def unit(self) -> str:
        """Unit of what it adds there."""
        return term.LOCATION_UNITS[self.table.location]

    @property
    def variable(self) -> str:
        """What it depends on."""
        return term.VARIABLES[self.table.variable]

    @property
    def variable_unit(self) -> str:
        """Unit of that."""
        return term.VARIABLE_UNITS[self.table.variable]

    @property
    def memory(self) -> float | None:
        """Time over which the variable is a change, s; None where it is none."""
        return self.table.memory if term.forgets(self.table) else None

    @property
    def reach(self) -> float | None:
        """Half the width of the play in which the variable is a place, N; None where in none."""
        return self.table.reach if term.has_play(self.table) else None

    @property
    def seen(self) -> tuple[float, float]:
        """The range of the variable in the record; the outermost knots lie beyond it, at zero."""
        return term.covered(self.table)

    @property
    def knots(self) -> Array:
        """Values of the variable at which the table has its own, shape (term.KNOTS,)."""
        inner = np.linspace(*self.seen, term.KNOTS - 2)
        return np.r_[self.table.low, inner, self.table.high]

    @property
    def values(self) -> Array:
        """What it adds there, shape (term.KNOTS,); with what is behind a play."""
        added = np.array(self.table.values)
        if self.reach is not None:
            added -= self.reach * np.clip(self.knots, -1.0, 1.0)
        return added


AS_GOOD_AS_MEASURED = 1.3
"""Ratio of error to noise up to which a model is called as good as the measurement."""

WORTH_SAYING = 0.01
"""Share of rows beyond what a model has been fitted to from which that is said."""


@dataclass(frozen=True)
class ChannelError:
    """
    Root mean square errors of one channel: parameters as given, refitted, with the effect.

    `left_open` is the standard uncertainty of what the last model predicts, for parameters that the
    record leaves open, and `unforeseen` what is left of `after` beyond it; NaN where the record was
    not met, or too few models were found that do. `mostly` are those of which a single one makes
    most of that, with the value that leaves `unforeseen`, NaN if there is none.
    """

    unit: str
    declared: float
    before: float
    after: float
    noise: float
    left_open: float = float('nan')
    unforeseen: float = float('nan')
    mostly: Mapping[str, float] = field(default_factory=dict)

    @property
    def met(self) -> bool:
        """Whether the last model leaves no more than noise."""
        return self.after <= AS_GOOD_AS_MEASURED * self.noise

    @property
    def foreseen(self) -> bool:
        """Whether it leaves no more than noise beyond what the record leaves open."""
        return self.met or self.unforeseen <= AS_GOOD_AS_MEASURED * self.noise


@dataclass(frozen=True)
class Alike:
    """
    Models, with where they begin, that suit a record as well as the one that was found.

    `one_off` are, by the name of a parameter, that one with it off to either side, all others as
    they are. `problem` and `fit` are those of that one.
    """

    models: tuple[tuple[PositionerParameters, Initial], ...]
    one_off: Mapping[str, tuple[tuple[PositionerParameters, Initial], ...]]
    problem: Problem = field(repr=False)
    fit: Fit = field(repr=False)


def errors_of(experiment: Experiment, runs: Mapping[str, Mapping[str, Array]], rows: Array
              ) -> dict[str, ChannelError]:
    """Return by channel what runs miss these rows by; runs by stage: declared, before, after."""
    errors = {}
    for name, measured in experiment.measured.items():
        declared, before, after = (
            rmse(measured, runs[stage][name], rows) for stage in ('declared', 'before', 'after'))
        errors[name] = ChannelError(
            UNITS[name], declared, before, after, experiment.noise[name])
    return errors


@dataclass(frozen=True)
class Refused:
    """
    A term without a name that did not stand: place and variable, errors held out with it.

    `beyond` is the share of what was held out that goes beyond what it was seen in. `error` is None
    where it explains too little of what it was fitted to.
    """

    location: str
    variable: str
    error: dict[str, float] | None
    beyond: float


@dataclass(frozen=True)
class Moved:
    """
    A declared parameter before and after a change.

    `left` is the mean square, in that of the noise, that this alone leaves of what came after.
    """

    name: str
    unit: str
    before: float
    after: float
    left: float


@dataclass(frozen=True)
class Change:
    """
    When the valve changed, s in the record's clock.

    `met` and `missed` are the mean squares, in that of the noise, that the declared model leaves
    before and from then on, refitted to what was before. The diagnosis is of what came after where
    the record was `cut` there. `moved` are the declared parameters, likeliest first, where a
    change of one of them is all that does; `silent` the channels that stand still since then while
    the model moves them.
    """

    time: float
    met: float
    missed: float
    cut: bool = False
    moved: tuple[Moved, ...] = ()
    silent: tuple[str, ...] = ()


@dataclass(frozen=True)
class Suspect:
    """A model that was tried: its effects, its mean square misfit (1 is noise), its fate."""

    effects: tuple[str, ...]
    misfit: float
    reason: str


HARDLY_TOLD = 0.8
"""Width of an interval, relative to that of the tolerance, from which a record hardly tells it."""

MOVED = 2.0
"""Tolerances: what a record has moved so far it does tell."""


@dataclass(frozen=True)
class Refitted:
    """
    A declared parameter: as given, refitted without and with the effect.

    `spread` is the tolerance within which it was expected, None where nothing was known;
    `away_before` and `away_after` say by how many of them the refits moved it (of a stop, by how
    many in what it yields). `at_limit` says that the last one ended at the end of what a refit
    allows; `low` and `high` are the 95 % interval of `after`, NaN there and where it was not fitted
    again, and `width` that of the interval relative to the tolerance's.
    """

    name: str
    unit: str
    given: float
    before: float
    after: float
    spread: float | None
    away_before: float
    away_after: float
    at_limit: bool = False
    low: float = float('nan')
    high: float = float('nan')
    width: float = float('nan')

    @property
    def hardly_told(self) -> bool:
        """Whether the record tells it hardly closer than it was expected before."""
        return self.width > HARDLY_TOLD and abs(self.away_after) < MOVED


@dataclass(frozen=True)
class FalseAdd:
    """
    How often the procedure added something to simulated records of a model that lacks nothing.

    `gained` of `runs` did; `low` and `high` are the 95 % interval of the rate (Clopper-Pearson);
    `names` counts what was added.
    """

    runs: int
    gained: int
    low: float
    high: float
    names: dict[str, int]

    @property
    def rate(self) -> float:
        """The share that gained something."""
        return self.gained / self.runs


@dataclass(frozen=True)
class Diagnosis:
    """
    The whole outcome; `runs` holds predictions by stage ('declared', 'before', 'after').

    `refused` is a term without a name that did not stand, and is not in the model; `start` the
    state that `after` begins in, None for that of the experiment. The locked part has `decided`
    where the verdict would be another one without it. `alike` are models that suit the record as
    well as `after`, None where nobody asked.
    """

    verdict: str
    effects: tuple[FoundEffect, ...]
    unknown: UnknownTerm | None
    error: dict[str, ChannelError]
    held_out: dict[str, ChannelError]
    suspects: tuple[Suspect, ...]
    refitted: tuple[Refitted, ...]
    declared: PositionerParameters
    before: PositionerParameters
    after: PositionerParameters
    experiment: Experiment
    segments: tuple[Segment, ...]
    runs: dict[str, dict[str, Array]] = field(repr=False)
    notes: tuple[str, ...] = ()
    validation: dict[str, ChannelError] = field(default_factory=dict)
    false_add: FalseAdd | None = None
    refused: Refused | None = None
    start: Initial | None = None
    decided: bool = False
    change: Change | None = None
    alike: Alike | None = field(default=None, repr=False)

    @property
    def added(self) -> bool:
        """Whether the model has something that it had not."""
        return self.verdict == 'effect' or self.unknown is not None
