# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The file of a campaign's outcomes: a line of JSON each, written as soon as a case has ended."""

from __future__ import annotations

from collections.abc import Sequence
import json
import os
from pathlib import Path

from .cases import CampaignError
from .scoring import Outcome, outcome_of, values_of

NAME = 'cases.jsonl'


def read_results(folder: Path) -> list[Outcome]:
    """
    Return the outcomes of a campaign, none where it has not begun.

    A last line that an end of the machine cut off is left out. CampaignError where the file holds
    something else.
    """
    path = folder / NAME
    if not path.exists():
        return []
    whole, _, _ = path.read_text(encoding='utf-8').rpartition('\n')
    try:
        return [outcome_of(json.loads(line)) for line in whole.splitlines()]
    except (KeyError, TypeError, ValueError, AttributeError):
        raise CampaignError(f'{path}: is not a file of outcomes') from None


def write_results(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write all outcomes anew: the file is the old one or the new one, never half of it."""
    write_whole(folder / NAME, ''.join(map(line_of, outcomes)))


def add_result(folder: Path, outcome: Outcome) -> None:
    """Append an outcome to the file."""
    with (folder / NAME).open('a', encoding='utf-8') as file:
        file.write(line_of(outcome))


def line_of(outcome: Outcome) -> str:
    """Return an outcome as a line of the file."""
    return json.dumps(values_of(outcome), ensure_ascii=False) + '\n'


def write_whole(path: Path, text: str) -> None:
    """Write a text file at once."""
    unfinished = path.with_name(f'.{path.name}.{os.getpid()}')
    unfinished.write_text(text, encoding='utf-8')
    os.replace(unfinished, path)


def by_case(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], Outcome]:
    """Return outcomes by the names of set and case; of two, the last."""
    return {(outcome.set, outcome.case): outcome for outcome in outcomes}
