# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says: plain data, for the report, the files and the tests."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from booster_ros.diagnosis.data.experiment import UNITS, Array, Experiment, Initial, rmse
from booster_ros.diagnosis.data.blocks import Segment
from booster_ros.diagnosis.estimation.uncertainty import Interval
from booster_ros.diagnosis.selection.decide import TraceStep
from booster_ros.model.discrepancy import Discrepancy
from booster_ros.model.system import PositionerParameters

STAGES = ('declared', 'before', 'after')
"""Models of a diagnosis: parameters as given, refitted, with the effect."""

Started = tuple[PositionerParameters, Initial]
"""A model with where it starts."""


@dataclass(frozen=True)
class FoundEffect:
    """
    An effect that the model lacked; `location` is where it is born.

    `separating_experiment` is empty where it has no name, `standing` is of selection/decide,
    `explained` its share of what the declared model left beyond noise.
    """

    name: str
    location: str
    parameters: dict[str, Interval]
    confused_with: tuple[str, ...]
    separating_experiment: str
    evidence: dict[str, float]
    standing: str = 'candidate'
    explained: float = float('nan')


AS_GOOD_AS_MEASURED = 1.3
"""Ratio of error to noise up to which a model is called as good as the measurement."""


@dataclass(frozen=True)
class ChannelError:
    """
    Root mean square errors of one channel: parameters as given, refitted, with the effect.

    `left_open` is the standard uncertainty of the last model's prediction by what the record leaves
    open, `unforeseen` what is left of `after` beyond it; NaN where the record was not met.
    """

    unit: str
    declared: float
    before: float
    after: float
    noise: float
    left_open: float = float('nan')
    unforeseen: float = float('nan')

    @property
    def met(self) -> bool:
        """Whether the last model leaves no more than noise."""
        return self.after <= AS_GOOD_AS_MEASURED * self.noise

    @property
    def foreseen(self) -> bool:
        """Whether the last model leaves no more than noise beyond what the record leaves open."""
        return self.met or self.unforeseen <= AS_GOOD_AS_MEASURED * self.noise


def errors_of(experiment: Experiment, runs: Mapping[str, Mapping[str, Array]], rows: Array
              ) -> dict[str, ChannelError]:
    """Return by channel how far `runs`, by stage, miss these rows."""
    errors = {}
    for name, measured in experiment.measured.items():
        declared, before, after = (rmse(measured, runs[stage][name], rows) for stage in STAGES)
        errors[name] = ChannelError(UNITS[name], declared, before, after, experiment.noise[name])
    return errors


@dataclass(frozen=True)
class Refused:
    """
    A term without a name that did not stand, its held-out errors, None if it explains too little.

    `beyond` is the share of held-out rows that go beyond the range in which the term was seen.
    """

    location: str
    variable: str
    error: dict[str, float] | None
    beyond: float


@dataclass(frozen=True)
class Change:
    """
    When the valve changed, s in the record's clock.

    `met` and `missed` are the mean squares, in the noise's, that the declared model, refitted to
    what came before, leaves before and from then on. The diagnosis of a record that was `cut` there
    is of what came after. `silent` channels stand still from then on while the model moves them.
    """

    time: float
    met: float
    missed: float
    cut: bool = False
    silent: tuple[str, ...] = ()


@dataclass(frozen=True)
class Suspect:
    """A model that was tried: its effects, its mean square misfit (1 is noise), its fate."""

    effects: tuple[str, ...]
    misfit: float
    reason: str


FAR_OFF = 2.0
"""Standard deviations, of a tolerance or of what is left open, that are more than chance."""


@dataclass(frozen=True)
class Refitted:
    """
    A declared parameter: as given, refitted without and with the effect.

    `spread` is its tolerance, None where nothing was known; `away_before` and `away_after` say by
    how many of them the refits moved it (of a stop, in what it yields), `at_limit` that the last
    one took it to the end of its range. `low` and `high` are the 95 % interval of `after`, NaN
    there and where it was not fitted again, `width` its width relative to the tolerance's.
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


@dataclass(frozen=True)
class FalseAdd:
    """
    To how many of so many simulated records, of a model that lacks nothing, something was added.

    `low` and `high` are the 95 % interval of the rate (Clopper-Pearson), `names` counts what.
    """

    runs: int
    gained: int
    low: float
    high: float
    names: dict[str, int]

    @property
    def rate(self) -> float:
        """Share of the records to which something was added."""
        return self.gained / self.runs


@dataclass(frozen=True)
class OtherRecord:
    """A record that only judges; `beyond` is the share of rows out of the range of a term."""

    notes: tuple[str, ...]
    drives: tuple[str, ...]
    channels: tuple[str, ...]
    beyond: float


@dataclass(frozen=True)
class Diagnosis:
    """
    The whole outcome; `runs` holds predictions by stage.

    `unknown` is the table of a term without a name that was added, `refused` one that did not
    stand; `start` is where `after` begins. `decided` says that without the test set the verdict
    would be another one. `alike` are models that suit the record as well as `after`, None if too
    few do. `notes` say what was dropped, mended or assumed.
    """

    verdict: str
    effects: tuple[FoundEffect, ...]
    unknown: Discrepancy | None
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
    other: OtherRecord | None = None
    false_add: FalseAdd | None = None
    refused: Refused | None = None
    start: Initial | None = None
    decided: bool = False
    change: Change | None = None
    alike: tuple[Started, ...] | None = field(default=None, repr=False)
    trace: tuple[TraceStep, ...] = ()

    @property
    def added(self) -> bool:
        """Whether something was added to the model."""
        return self.verdict == 'effect' or self.unknown is not None
