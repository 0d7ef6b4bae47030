# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the declared model moves beside a record, whatever is asked of the two."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment, rmse
from booster_ros.model.system import PositionerParameters
from booster_ros.records.holding import bridged

Array = np.ndarray

FOLLOWS = 0.8
"""Correlation from which on a channel moves as the declared model does."""

EXPLAINED = 0.3
"""Share of the declared model's error that is left where the record is taken otherwise (in absolute
pressure, in another unit of time, with a reversed current), below which it is to be taken so: a
tenth of its square."""

SMALLEST = 1e-12


def alike(measured: Array, predicted: Array) -> float:
    """Return the correlation of two channels, 0 where one does not move."""
    both = np.isfinite(measured) & np.isfinite(predicted)
    if not both.any() or np.std(predicted[both]) == 0.0 or np.std(measured[both]) == 0.0:
        return 0.0
    return float(np.corrcoef(measured[both], predicted[both])[0, 1])


def follows(experiment: Experiment, declared: PositionerParameters) -> bool:
    """Tell whether the declared model moves as measured, whatever the size."""
    predicted = experiment.predict(declared)
    return all(alike(measured, predicted[name]) > FOLLOWS
               for name, measured in experiment.measured.items())


def stem_alone(experiment: Experiment) -> Experiment:
    """Return the experiment with the stem driven by the measured pressure."""
    pressure = bridged(experiment.time, experiment.measured['chamber_pressure'])
    return replace(
        experiment, current=np.zeros_like(experiment.current), command='control_current',
        measured={'valve_position': experiment.measured['valve_position']},
        pinned={**experiment.pinned, 'chamber_pressure': pressure})


def sizes_of(experiment: Experiment, predicted: Mapping[str, Array]) -> dict[str, float]:
    """Return how much each compared channel moves, as measured or as predicted."""
    # a dead sensor does next to nothing, as a share of which its error would outweigh all else
    return {name: max(float(np.nanstd(measured)), float(np.std(predicted[name])), SMALLEST)
            for name, measured in experiment.measured.items()}


def is_otherwise(recorded: Experiment, taken: Experiment, declared: PositionerParameters) -> bool:
    """Tell whether the declared model misses a record far less if it is taken otherwise."""
    predicted = recorded.predict(declared)
    sizes = sizes_of(recorded, predicted)
    return miss(taken, taken.predict(declared), sizes) < EXPLAINED * miss(
        recorded, predicted, sizes)


def miss(experiment: Experiment, predicted: Mapping[str, Array], sizes: Mapping[str, float]
         ) -> float:
    """Return the error of a prediction, summed over channels as shares of their `sizes`."""
    every = np.ones(len(experiment.time), dtype=bool)
    return sum(rmse(measured, predicted[name], every) / sizes[name]
               for name, measured in experiment.measured.items())
