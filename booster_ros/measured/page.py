# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""docs/measured.md: numbers come from results, or from a printed source that is named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..diagnosis.data.experiment import rmse
from ..diagnosis.result import Diagnosis, FoundEffect, Suspect
from ..model.catalogue import EFFECTS
from ..model.system import PositionerParameters
from ..paper.comparison import LABELS
from ..paper.indices import StepIndices
from ..paper.printed import PrintedIndex
from ..paper.table_three import Suspect as IndexSuspect
from ..report.engineering import (
    Scale, digits_apart, interval_text, number, si_scale, si_text)
from ..report.names import capital, channel_label, effect_label, listing
from ..report.wording import verdict_sentences, verdict_title, with_what_was_added
from . import remarks
from .records import MeasuredRecord
from .supplies import SPLITS, Prediction, left_out

MOST_ADDITIONS, MOST_OTHERS = 2, 5
"""How many models are shown that hold the choice and more, and that do not."""


def document(sections: Sequence[str]) -> str:
    """Return the page."""
    text = '\n'.join(sections)
    return f"""# `close_loop` on real measurements

Written by `make measured`: every number below is computed by what is committed, or is from the
printed source that stands beside it. The records are by others and of other devices; each covers a
piece of the chain ([measured/README.md](../measured/README.md)). Each was run as a user would:

```
python -m booster_ros close_loop --record measured/NAME.csv --params PARAMETERS --out DIR
```

*Declared* is the model with the parameters as given, *refitted* with them turned within their
tolerances, *with the effect* what `close_loop` writes. *Held out* rows were opened once, at the
end. *Noise* is what the record's own scatter tells; errors above it are not explained. *Tried* are
the choice, what was added to it, and what was tried instead, best first. *Misfit* is the mean
square of the residuals on the rows that were fitted, in units of the noise: 1 is noise, 100 is ten
times the noise. In the figures hollow points or a shaded end are held out.

{text}"""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ['---'] * len(head), *rows]
    return '\n'.join(f'| {" | ".join(cells)} |' for cells in lines) + '\n'


def figure_file(record: MeasuredRecord) -> str:
    """Return where a record's figure is, relative to docs/."""
    return f'figures/measured_{record.name}.svg'


def section(record: MeasuredRecord, diagnosis: Diagnosis) -> str:
    """Return the text on one record."""
    verdict = ' '.join([f'**{verdict_title(diagnosis)}.**', *verdict_sentences(diagnosis)])
    parts = [
        f'## {record.title}\n',
        f'{capital(record.what)}. Source: {record.source}. `{record.record_file}` with '
        f'`{record.parameters}`.\n',
        f'{verdict}\n',
        f'![{record.title}: measured, refitted, with the effect, and what is left]'
        f'({figure_file(record)})\n',
        error_table(record, diagnosis),
        *[effect_table(effect, diagnosis.declared)
          for effect in diagnosis.effects if effect.parameters],
        suspect_table(diagnosis),
        ' '.join(remarks.on(record, diagnosis)) + '\n',
    ]
    return '\n'.join(parts)


def error_table(record: MeasuredRecord, diagnosis: Diagnosis) -> str:
    """Return errors on fitted and held-out rows beside the noise, in the unit of the record."""
    shown = {'declared': 'declared', 'before': 'refitted'}
    if diagnosis.added:
        shown['after'] = with_what_was_added(diagnosis)
    rows = []
    for part, errors in (('fitted', diagnosis.error), ('held out', diagnosis.held_out)):
        for name, error in errors.items():
            rows.append([f'{channel_label(name)}, {part}',
                         *(_count(getattr(error, stage), record.unit) for stage in shown),
                         _count(error.noise, record.unit)])
    everywhere = np.ones(len(diagnosis.experiment.time), dtype=bool)
    for name, measured in diagnosis.experiment.measured.items():
        rows.append([f'{channel_label(name)}, all rows', *(
            _count(rmse(measured, diagnosis.runs[stage][name], everywhere), record.unit)
            for stage in shown), _count(diagnosis.experiment.noise[name], record.unit)])
    return table([f'RMS error, {record.unit.unit}', *shown.values(), 'noise'], rows)


def _count(value: float, unit: Scale) -> str:
    return number(value * unit.factor)


def effect_table(effect: FoundEffect, declared: PositionerParameters) -> str:
    """Return the sizes of an effect in such a valve with their 95 % intervals."""
    rows = []
    for name, interval in effect.parameters.items():
        knob = remarks.knob_of(effect.name, name, declared)
        if remarks.is_none(knob, interval):
            rows.append([f'`{name}`', 'none', ''])
            continue
        digits = digits_apart(interval.low, interval.high)
        value = 'none' if interval.is_none else si_text(interval.value, interval.unit, digits)
        rows.append([f'`{name}`', value, interval_text(
            si_scale(interval.unit), interval.low, interval.high, digits, interval.open_above)])
    return table([effect_label(effect.name), 'value', '95 % interval'], rows)


def suspect_table(diagnosis: Diagnosis) -> str:
    """Return the best of what was tried, with the reason why each was dropped."""
    chosen = {effect.name for effect in diagnosis.effects}
    same = [s for s in diagnosis.suspects if set(s.effects) == chosen]
    more = sorted((s for s in diagnosis.suspects if set(s.effects) > chosen),
                  key=lambda s: len(s.effects))
    others = [s for s in diagnosis.suspects if not set(s.effects) >= chosen]
    rows = [[_model(suspect), number(suspect.misfit), suspect.reason]
            for suspect in (*same, *more[:MOST_ADDITIONS], *others[:MOST_OTHERS])]
    return table(['tried', 'misfit (1 is noise)', 'why dropped'], rows)


def _model(suspect: Suspect) -> str:
    return ' + '.join(effect_label(name) for name in suspect.effects) or 'nothing added'


def across_supplies(found: Mapping[str, Sequence[Prediction]]) -> str:
    """Return how each model, fitted to some supply pressures, predicts another."""
    rows = []
    for k, (fitted, predicted) in enumerate(SPLITS):
        of = ', '.join(f'{supply / 1e3:.0f}' for supply in fitted)
        rows.append([f'{of} → {predicted / 1e3:.0f}',
                     *(number(each[k].predicted) for each in found.values())])
    rows.append(['one supply left out, all rows', *(
        number(left_out(list(each))) for each in found.values())])
    return '\n'.join([
        '## Table I from one supply pressure to another\n',
        'Fitted to the rows of some supply pressures (kPa, left of the arrow), judged on those of '
        'another; RMS error in table units. A model that is right at one supply pressure '
        'only is of little use, so this counts more than the errors above.\n',
        table(['fitted → predicted, kPa', *found], rows),
        ' '.join(remarks.on_supplies(found)) + '\n',
    ])


def ranking(
    printed: Mapping[str, PrintedIndex], played: StepIndices, suspects: Sequence[IndexSuspect]
) -> str:
    """Return Table III and which effects could turn its one column into the other."""
    indices = table(
        ['', 'measured', 'simulated', 'error', 'our model'],
        [[f'{label}, {printed[name].unit}', f'{printed[name].measured:g}',
          f'{printed[name].simulated:g}',
          f'{1.0 - printed[name].simulated / printed[name].measured:.2%}',
          number(getattr(played, name), 5)] for name, label in LABELS.items()])
    wanted = [np.log(printed[name].measured / printed[name].simulated) for name in LABELS][1:]
    nothing = float(np.sqrt(np.mean(np.square(wanted))))
    helpful = [one for one in suspects if one.mismatch < 0.99 * nothing]
    rest = [effect_label(one.name) for one in suspects if one not in helpful]
    hidden = [effect_label(name) for name, effect in EFFECTS.items()
              if name not in {one.name for one in suspects}
              and effect.location != 'position_controller']  # which is off
    return '\n'.join([
        '## Table III: three numbers that differ\n',
        'The paper prints four indices of one step, 0 → 0.4524 mA, measured and simulated.\n',
        indices,
        'Each effect of the catalogue was added alone to the model that gives the simulated '
        'column, its sizes fitted so that both times and the integral move as the measured '
        'column differs, the E/P gain turned along so that the final pressure stays. *Left* is '
        f'the RMS of what remains of the three differences ({nothing:.2%} if nothing is added). '
        '*Direction* is the cosine between the wanted change and the nearest that small sizes of '
        'the effect make: 1 is the same direction.\n',
        table(['effect', 'left', 'direction', 'sizes fitted'], [
            [effect_label(one.name), f'{one.mismatch:.2%}', f'{one.cosine:.2f}',
             ', '.join(f'`{name}` {number(size)}' for name, size in one.sizes.items())]
            for one in helpful]),
        f'No help, at any size that was reached: {listing(rest)}. '
        f'Not seen in a step of pressure: {listing(hidden)}. Sizes are in SI units.\n',
        ' '.join(remarks.on_ranking(helpful)) + '\n',
    ])
