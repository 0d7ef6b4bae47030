# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The state of a positioner: a sequence of floats in the order of these indices.

States whose effect is switched off stand still and cost nothing: the solver integrates the
`active_states` only.
"""

BACK, SUPPLY, OUTLET, CHAMBER, TEMPERATURE, PAST, POSITION, VELOCITY, PRESLIDING = range(9)
STATES = 9
STATE_NAMES = ('back_pressure', 'supply_pressure', 'outlet_pressure', 'chamber_pressure',
               'gas_temperature', 'past', 'valve_position', 'stem_velocity', 'presliding_force')
