# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an effect is: its name, its place, and the parameters that a fit turns to size it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Knob:
    """
    One parameter of an effect as a fit turns it.

    `typical` is a size that a record shows well, `low` and `high` bound the search (SI units,
    `neutral` included where the effect vanishes there). Where `inverse` is n > 0, value**-n is
    fitted instead of the value: a restriction vanishes as its area grows, its drop as 1/area².
    """

    parameter: str
    typical: float
    low: float
    high: float
    neutral: float = 0.0
    inverse: int = 0
    shape: bool = False  # a shape parameter means nothing while the size is neutral
    clocked: bool = False  # it acts through time or speeds, which a sweep without a clock lacks
    tried: tuple[float, ...] = ()  # values of a shape with each of which sizes are tried
    frequency: bool = False  # how often the effect repeats itself, Hz
    phase: bool = False  # where in its period it begins, rad
    rubs: bool = False  # friction of a sliding stem, without which the other sizes are none
    departs: str = ''  # what may be off at the start only with this size: a field of `Departure`
    goes_with: str = ''  # unit in proportion to which it is sought, where that is not its own

    def to_fit(self, value: float) -> float:
        """Return the fitted variable for a value."""
        if not self.inverse:
            return value
        return 0.0 if value <= 0.0 else value**-self.inverse

    def from_fit(self, variable: float) -> float:
        """Return the value for a fitted variable; an inverse knob is neutral from `high` on."""
        if not self.inverse:
            return variable
        vanishing = self.high**-self.inverse
        return self.neutral if variable <= vanishing else variable**(-1.0 / self.inverse)


@dataclass(frozen=True)
class Effect:
    """
    A named effect: where it is born, its knobs, what a record needs to show it, what separates it.

    `loosens` names the declared parameters that are known less well where this effect is present,
    `reading` the channel whose sensor it falsifies, `driven_by` the measured channel in proportion
    to which it acts. `orifice_law` is the only law of flow through the seats that knows the effect,
    None where any does. `sets` are parameters that are otherwise than declared wherever the effect
    is, whatever its size.
    """

    name: str
    location: str
    knobs: tuple[Knob, ...]
    meaning: str
    needs: str
    separating_experiment: str
    source: str
    loosens: tuple[str, ...] = ()
    reading: str = ''
    orifice_law: int | None = None
    driven_by: str = ''
    sets: tuple[tuple[str, float], ...] = ()

    @property
    def needs_clock(self) -> bool:
        """Whether no size of it acts in a sweep without a clock."""
        return all(knob.clocked for knob in self.knobs if not knob.shape)

    @property
    def rubs(self) -> bool:
        """Whether it is friction of the stem."""
        return any(knob.rubs for knob in self.knobs)
