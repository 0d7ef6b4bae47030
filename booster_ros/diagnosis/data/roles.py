# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which channels of a record drive the model and which are compared with it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from booster_ros.records import COLUMNS, RecordError

_NO_BOOSTER = 'mass_flow is not compared: without control_current or back_pressure nothing says '\
    'how far the booster is open'
_ISOLATED = 'no drive in the record: the chamber is taken as shut off, as declared'
_UNSEEN = 'pressure_drop is not used: nothing else that drives the stem, and no position, is there'


@dataclass(frozen=True)
class Roles:
    """
    What each channel of a record does.

    `pinned` channels stand in for the model's own states, the fastest-moving one first; the
    column `command` drives where `commanded`: the control current, or a set point by way of the
    position controller.
    """

    commanded: bool
    pinned: tuple[str, ...]
    compared: tuple[str, ...]
    notes: tuple[str, ...] = ()
    command: str = 'control_current'

    @property
    def drives(self) -> tuple[str, ...]:
        """The columns that the model is driven with."""
        return (self.command, *self.pinned) if self.commanded else self.pinned


def roles(present: Collection[str], source: str, ignored: Sequence[str] = ()) -> Roles:
    """
    Return the roles of the columns present: the most upstream ones drive, the others are compared.

    RecordError where nothing would be left to compare, or nothing says what moves the valve. Its
    message ends with what is said of columns that were `ignored`: the one that is missing may be
    among them.
    """
    timed = 'time' in present
    found = _roles(present, timed)
    if found is None or not found.compared:
        columns = ', '.join(name for name in COLUMNS if name in present and name != 'time')
        clock = '' if timed else ' and no time'
        lacks = 'and nothing downstream of that to compare' if found else (
            'and needs a drive (control_current, back_pressure, chamber_pressure, or a set_point '
            'with position_controller.enabled: true in the parameters) and a channel downstream '
            'of it')
        raise RecordError('; '.join((
            f'{source}: nothing can be compared with the model: the record has {columns}{clock}, '
            f'{lacks}', *ignored)))
    return found


def _roles(present: Collection[str], timed: bool) -> Roles | None:
    def those(*names: str) -> tuple[str, ...]:
        return tuple(name for name in names if name in present)

    beside = those('supply_pressure', 'pressure_drop')
    if 'control_current' in present:
        compared = those('back_pressure', 'mass_flow', 'chamber_pressure', 'valve_position')
        return Roles(True, beside, compared)
    booster_known = bool(those('back_pressure', 'supply_pressure'))
    if not timed and booster_known and those('mass_flow', 'chamber_pressure') == (
            'mass_flow', 'chamber_pressure'):
        return _flow_bench(those('back_pressure', 'chamber_pressure', 'supply_pressure'),
                           those('valve_position', 'pressure_drop'))
    if 'set_point' in present:  # the caller has seen that it may drive
        compared = those('mass_flow', 'chamber_pressure', 'valve_position')
        return Roles(True, beside, compared, command='set_point')
    if 'back_pressure' in present:
        compared = those('mass_flow', 'chamber_pressure', 'valve_position')
        return Roles(False, ('back_pressure', *beside), compared)
    notes = those('mass_flow') and (_NO_BOOSTER,)
    if those('chamber_pressure', 'valve_position') == ('chamber_pressure', 'valve_position'):
        return Roles(False, ('chamber_pressure', *beside), ('valve_position',), notes)
    if 'chamber_pressure' in present and timed:
        notes += those('pressure_drop') and (_UNSEEN,)
        return Roles(False, those('supply_pressure'), ('chamber_pressure',), (*notes, _ISOLATED))
    return None


def _flow_bench(pinned: tuple[str, ...], idle: tuple[str, ...]) -> Roles:
    """Return the roles on a bench that sets the pressures around the booster and reads its flow."""
    notes = tuple(f'{name} is not used: a flow bench is judged by its flow' for name in idle)
    if 'back_pressure' not in pinned:
        notes += ('no back_pressure in the record: taken as that of no current',)
    return Roles(False, pinned, ('mass_flow',), notes)
