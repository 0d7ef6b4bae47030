# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as the figures need it: which two models are shown, over what, in which units."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from booster_ros.diagnosis.data.experiment import UNITS
from booster_ros.diagnosis.data.blocks import rows_of
from booster_ros.diagnosis.result import Diagnosis
from booster_ros.model.term_course import followed
from booster_ros.model import discrepancy
from booster_ros.report.engineering import Scale, scale_of
from booster_ros.report.names import channel_label
from booster_ros.report.unknown_term import unknown_of
from booster_ros.report.wording import with_what_was_added

Array = np.ndarray

_UNITS = {**UNITS, **dict(zip(discrepancy.VARIABLES, discrepancy.VARIABLE_UNITS))}


@dataclass(frozen=True)
class View:
    """
    A diagnosis to be drawn.

    Where nothing was added, the declared parameters as given are shown beside the refitted ones.
    """

    diagnosis: Diagnosis

    @property
    def stages(self) -> tuple[str, str]:
        """The two models that are compared, worse first."""
        return ('before', 'after') if self.diagnosis.added else ('declared', 'before')

    @property
    def stage_labels(self) -> tuple[str, str]:
        """Words for the two models."""
        if not self.diagnosis.added:
            return 'model as declared', 'refitted'
        return 'refitted, nothing added', with_what_was_added(self.diagnosis)

    @property
    def time(self) -> Array:
        """Time of the rows, s."""
        return self.diagnosis.experiment.time

    @property
    def locked(self) -> Array:
        """Which rows were held out, shape (n,)."""
        return rows_of(list(self.diagnosis.segments), 'test', len(self.time))

    @property
    def channels(self) -> tuple[str, ...]:
        """The compared channels."""
        return self.diagnosis.experiment.channels

    def measured(self, name: str) -> Array:
        """Return a compared channel, NaN where a row does not count, in engineering units."""
        return self.diagnosis.experiment.measured[name] * scale(name).factor

    def model(self, stage: str, name: str) -> Array:
        """Return what a model says of a compared channel, in engineering units."""
        return self.diagnosis.runs[stage][name] * scale(name).factor

    def residual(self, stage: str, name: str) -> Array:
        """Return measured minus model, in engineering units."""
        return self.measured(name) - self.model(stage, name)

    def noise(self, name: str) -> float:
        """Return the noise of a compared channel, in engineering units."""
        return self.diagnosis.experiment.noise[name] * scale(name).factor

    @property
    def drives(self) -> tuple[str, ...]:
        """The driving channels that are worth a look: those that move after row 0, else all."""
        drives = self.diagnosis.experiment.drives
        return tuple(name for name in drives if np.ptp(self.drive(name)[1:]) > 0.0) or drives

    def drive(self, name: str) -> Array:
        """Return a driving channel in engineering units; a sweep's current is NaN in its row 0."""
        experiment = self.diagnosis.experiment
        if name != experiment.command:
            return experiment.pinned[name] * scale(name).factor
        current = experiment.current
        if experiment.quasi_static:  # a sweep's row was read at the end of the current before it
            current = np.append(np.nan, current[:-1])
        return current * scale(name).factor

    @property
    def driver(self) -> str | None:
        """The channel that a sweep is plotted over: the first that drives it."""
        return self.drives[0] if self.drives else None

    @cached_property
    def states(self) -> dict[str, Array]:
        """What the better model says of everything a residual may depend on, SI."""
        experiment, unknown = self.diagnosis.experiment, unknown_of(self.diagnosis)
        start = self.diagnosis.start or experiment.initial
        run = experiment.simulate(self.diagnosis.after, start)
        states = {name: run[name] for name in ('time', *VARIABLES)}
        if unknown is not None:
            states[unknown.variable] = followed(
                self.diagnosis.after, experiment.time, run.columns, start.departure.past)
        return states

    def state(self, name: str) -> Array:
        """Return one of the states, in engineering units."""
        return self.states[name] * scale(name).factor


VARIABLES = ('control_current', 'back_pressure', 'supply_pressure', 'booster_force', 'mass_flow',
             'chamber_pressure', 'valve_position', 'stem_velocity')
"""Variables by which a residual may be explained; over time it is shown in any case."""


def scale(name: str) -> Scale:
    """Return the engineering unit of a channel."""
    return scale_of(_UNITS[name])


def axis_label(name: str) -> str:
    """Return the label of an axis that shows a channel."""
    unit = scale(name).unit
    return f'{channel_label(name)}, {unit}' if unit else channel_label(name)
