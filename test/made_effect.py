# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Made-up rows of the catalogue: what is done with an effect must follow from its row alone."""

from booster_ros.model.catalogue import EFFECTS, Effect


def add_effect(monkeypatch, name, location, *knobs, **facts):
    """Add an effect to the catalogue for the length of a test."""
    monkeypatch.setitem(EFFECTS, name, Effect(
        name, location, knobs, 'meaning', 'needs', 'experiment', 'source', **facts))
