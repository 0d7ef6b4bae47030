# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Say what a model lacks, judged by a record, and write the model that has it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
import difflib
from functools import partial
from io import TextIOWrapper
import os
from pathlib import Path
import sys
from typing import Any

from ..diagnosis.judging.false_positive_rate import calibrated
from ..diagnosis.judging.change_point import since_change
from ..diagnosis.pipeline import diagnose
from ..diagnosis.data.experiment import Experiment
from ..diagnosis.prepare.plausibility import check_declared
from ..diagnosis.prepare.preparation import prepare
from ..diagnosis.prepare.rows import DWELL_FILLED, DWELL_PINNED
from ..diagnosis.result import Diagnosis
from ..diagnosis.selection.task import PLACES
from ..diagnosis.judging.validation import validated
from ..legible import legible
from ..model.catalogue import EFFECTS
from ..model.parameters import ParameterError, from_values
from ..model.system import PositionerParameters
from ..parameters.file import read_parameter_file
from ..records import (
    COLUMNS, FileMapping, Record, RecordError, check_inputs_stay, is_bag, read_mapping, read_record)
from ..report.json_report import json_text
from ..report.parameter_files import write_parameter_files
from ..report.provenance import Provenance
from ..report.wording import verdict_sentences, verdict_title
from ..surroundings import INTERRUPTED
from ..writing import unfinished
from ..writing.replacement import keep, replace_all
from .compiling import announce_compilation
from .interruption import ignore_interruptions, kept_interruption
from .mapping_options import (
    add_mapping_options, mapping_for, pointing_to_inspect)
from .number_arguments import count_of, seconds
from .path_argument import given_path
from .progress_bar import ProgressBar
from .telling import complain

WRITTEN = ('report.json', 'report.html', 'positioner.yaml', 'positioner_before.yaml')
"""The files of a result."""

WORKING = 'close_loop'
"""What the name of the folder has in it in which these are made, in or above that of the result."""

SEED = 1


def main(args: Sequence[str] | None = None) -> int:
    """Diagnose a record and write the report; return the exit status."""
    options = _parser().parse_args(args)
    with kept_interruption() as check:
        try:
            diagnosis = _close_loop(options, check)
        except (ParameterError, RecordError) as error:
            complain('close_loop', error)
            return 2
        except OSError as error:
            hidden = f'.{WORKING}.' in str(error.filename or '')
            place = options.out if hidden else error.filename or options.out
            complain('close_loop', f'{place}: {error.strerror}')
            return 2
        except KeyboardInterrupt:
            complain('close_loop', 'interrupted, nothing was written')
            return INTERRUPTED
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors='replace')  # not every terminal knows a thin space
    print(f'{verdict_title(diagnosis)}.', *verdict_sentences(diagnosis), sep='\n  ')
    print(f'Report: {legible(options.out / "report.html")}')
    return 0


def _close_loop(options: argparse.Namespace, check: Callable[[], None]) -> Diagnosis:
    _check_paths(options)
    _check_options(options)
    names, places = _hypotheses(options)
    judge = partial(diagnose, names=names, places=places)
    given = read_parameter_file(options.params)
    declared = from_values(given.physical)
    check_declared(declared, str(options.params))
    with _output_folder(options.out) as folder:  # asked first: the search may take minutes
        records = _records(options, declared)
        announce_compilation()
        (record, experiment, notes), *others = _experiments(options, records, declared)
        _tell_notes(options, [notes, *(more for _, _, more in others)])
        with _progress(check) as tell:
            try:
                diagnosis = judge(experiment, declared, tell, notes=notes)
            except RecordError as error:
                raise RecordError(f'{options.record}: {error}') from None
            diagnosis = since_change(diagnosis, record, judge, tell)
            for _, other, more in others:
                diagnosis = validated(diagnosis, other, more)
        if options.calibrate:
            with _progress(check) as tell:
                diagnosis = calibrated(
                    diagnosis, options.calibrate,
                    SEED if options.seed is None else options.seed, judge, tell)
        _write(folder, diagnosis, Provenance(*map(
            legible, (options.record, options.params, options.validation or ''))), given.node)
        check()
    return diagnosis


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='close_loop',
        description='Compare the model with a record of a valve, say which effect it lacks, and '
        'write the model that has it.',
        epilog=f'R is a CSV file with any of the columns {", ".join(COLUMNS)} (SI units, gauge '
        'pressures), a rosbag2 bag, or a file that --map or --column tell how to read. The most '
        'upstream channels drive the model, the others are compared. DIR gets report.html, '
        'report.json, positioner.yaml (the model with what it lacked) and positioner_before.yaml '
        '(the declared model refitted).',
    )
    add = parser.add_argument
    add('--record', type=given_path, required=True, metavar='R', help='the record to explain')
    add('--params', type=given_path, required=True, metavar='P.yaml',
        help='the declared parameters')
    add('--out', type=given_path, required=True, metavar='DIR', help='folder for what is written')
    add('--validation', type=given_path, metavar='V', help='another record, for judging only')
    add_mapping_options(parser)
    add('--validation-map', type=given_path, metavar='M.yaml',
        help='how the other record is read (default: as the record)')
    add('--topics', nargs='+', type=_topic, default=[], metavar='COLUMN=TOPIC',
        help='topics of a bag that do not go by the names of the columns; TOPIC:NAME picks an '
        'element of a JointState')
    add('--stamps', choices=('bag', 'header'), default='bag',
        help='time of a bag: when it was recorded, or the stamps in the messages '
        '(default: %(default)s)')
    add('--dwell', type=seconds, metavar='S',
        help='how long each row of a sweep without time stood, s (default: '
        f'{DWELL_FILLED:g}, where the chamber pressure drives {DWELL_PINNED:g})')
    add('--calibrate', type=count_of('records'), metavar='N',
        help='also count how often something is added to N simulated records in which nothing is '
        'missing; each takes as long as a diagnosis')
    among = parser.add_mutually_exclusive_group().add_argument
    among('--only', nargs='+', default=[], metavar='EFFECT',
          help='try these effects of the catalogue alone, and no term without a name')
    among('--without', nargs='+', default=[], metavar='EFFECT', help='do not try these effects')
    add('--seed', type=_seed, metavar='S',
        help=f'of the noise in those records (default: {SEED})')
    return parser


def _topic(text: str) -> tuple[str, str]:
    column, _, topic = text.partition('=')
    if not topic:
        raise argparse.ArgumentTypeError(f'{text!r} is not COLUMN=TOPIC')
    return column, topic


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f'{text!r} is not a whole number from 0 on')
    return int(text)


def _records(options: argparse.Namespace, declared: PositionerParameters) -> list[Record]:
    """Return the record, then the other one if given; RecordError where the options do not fit."""
    records = []
    for path in _given(options):
        with pointing_to_inspect(path):
            records.append(read_record(
                path, dict(options.topics), options.stamps, _mapping(options, path),
                declared.actuator.travel))
    if options.dwell and all('time' in record for record in records):
        raise RecordError(_useless('--dwell', 'a sweep without time', options))
    if len(records) > 1 and records[0].has_rows_of(records[1]):
        raise RecordError(f'{options.validation}: has the rows of the record itself; --validation '
                          'takes another one')
    return records


def _experiments(
    options: argparse.Namespace, records: Sequence[Record], declared: PositionerParameters
) -> list[tuple[Record, Experiment, tuple[str, ...]]]:
    """Return each record with its experiment and notes."""
    experiments = []
    for path, record in zip(_given(options), records, strict=True):
        with pointing_to_inspect(path):
            experiments.append(prepare(record, declared, options.dwell))
    return [(record, experiment, (*record.notes, *experiment.notes))
            for record, experiment in zip(records, experiments, strict=True)]


def _mapping(options: argparse.Namespace, path: Path) -> FileMapping | None:
    """Return the mapping of the record, or of the other one, which has one of its own if given."""
    if path is options.validation and options.validation_map:
        return read_mapping(options.validation_map)
    return mapping_for(path, options)


def _tell_notes(options: argparse.Namespace, notes: Sequence[Sequence[str]]) -> None:
    """Print the notes on each record before minutes go into it; the report has them as well."""
    for path, sentences in zip(_given(options), notes, strict=True):
        for sentence in sentences:
            complain(str(path), sentence)


def _given(options: argparse.Namespace) -> list[Path]:
    """Return the paths of the record and, where it is given, of the other one."""
    return [path for path in (options.record, options.validation) if path is not None]


def _useless(option: str, purpose: str, options: argparse.Namespace) -> str:
    """Return the sentence about an option that fits none of the records given."""
    names = [legible(path) for path in _given(options)]
    verb = 'is' if len(names) == 1 else 'are'
    return f'{option} is for {purpose}, and {" and ".join(names)} {verb} none'


@contextmanager
def _progress(check: Callable[[], None]) -> Iterator[Callable[[str, float], None]]:
    """Yield a function that calls `check` and shows phrase and share done in a terminal's bar."""
    form = '{percentage:3.0f}% |{bar}| {elapsed} {desc}'
    with ProgressBar(total=1.0, bar_format=form, disable=None, leave=False) as bar:
        def tell(phrase: str, share: float) -> None:
            check()
            bar.set_description_str(phrase, refresh=False)
            bar.update(max(share - bar.n, 0.0))

        yield tell


@contextmanager
def _output_folder(out: Path) -> Iterator[Path]:
    """Yield a temporary folder whose files are moved to `out` when everything is written."""
    if out.is_symlink() and not out.exists():
        raise RecordError(f'{out}: is a link to what is not there')
    for name in WRITTEN:
        if (out / name).is_dir():
            raise RecordError(f'{out / name}: is a folder, a file is to be written there')
    nearest = next(folder for folder in (out, *out.absolute().parents) if folder.exists())
    if not nearest.is_dir():
        raise RecordError(f'{nearest}: is not a folder')
    with unfinished.folder(nearest / WORKING) as work:
        earlier = work / 'earlier'
        earlier.mkdir()
        for name in WRITTEN:
            if keep(out / name, earlier / name):  # what cannot be kept cannot be replaced either
                (earlier / name).unlink()
        yield work
        out.mkdir(parents=True, exist_ok=True)
        ignore_interruptions()  # the files of a result are all new, or none is
        replace_all(work, out, WRITTEN, earlier)


def _check_paths(options: argparse.Namespace) -> None:
    """Raise RecordError where an input would be overwritten, or a record would judge itself."""
    records = _given(options)
    targets = [options.out / name for name in WRITTEN]
    maps = [path for path in (options.map, options.validation_map) if path is not None]
    check_inputs_stay([*records, options.params, *maps], targets, '--out')
    if not options.validation_map and (
            len({os.path.realpath(path) for path in records}) < len(records)):
        raise RecordError(
            f'{options.validation}: is the record itself; --validation takes another one')


def _check_options(options: argparse.Namespace) -> None:
    """Raise RecordError for an option of a bag, or of --calibrate, where there is none."""
    if options.validation_map and options.validation is None:
        raise RecordError('--validation-map is for --validation, which was not given')
    if options.seed is not None and not options.calibrate:
        raise RecordError('--seed is for --calibrate, which was not given')
    asked = {'--topics': options.topics, '--stamps header': options.stamps == 'header'}
    for option, wanted in asked.items():
        if wanted and not any(map(is_bag, _given(options))):
            raise RecordError(_useless(option, 'a bag', options))


def _hypotheses(options: argparse.Namespace) -> tuple[tuple[str, ...], frozenset[str]]:
    """
    Return the effects to try, and the places where a term without a name may be.

    RecordError for an effect that is not in the catalogue.
    """
    for option in ('only', 'without'):
        for name in getattr(options, option):
            if name not in EFFECTS:
                near = difflib.get_close_matches(name, list(EFFECTS), 1, 0.5)
                hint = f'; did you mean {near[0]}?' if near else ''
                raise RecordError(
                    f'--{option}: there is no effect {name!r} in the catalogue{hint} '
                    f'(it has {", ".join(EFFECTS)})')
    if options.only:
        return tuple(options.only), frozenset()
    return tuple(name for name in EFFECTS if name not in options.without), PLACES


def _write(folder: Path, diagnosis: Diagnosis, provenance: Provenance, node: Mapping[str, Any]
           ) -> None:
    from ..report.html_report import html_page  # draws, which takes half a second to import

    (folder / 'report.json').write_text(json_text(diagnosis, provenance), encoding='utf-8')
    (folder / 'report.html').write_text(html_page(diagnosis, provenance), encoding='utf-8')
    write_parameter_files(folder, diagnosis, provenance, node)


if __name__ == '__main__':
    sys.exit(main())
