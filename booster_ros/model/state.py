# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The state of a positioner: a sequence of floats in the order of these indices.

States whose effect is switched off stand still and cost nothing: the solver integrates the
`active_states` only. The last state, the pressure drop over the process valve, is an input, which
no equation moves.
"""

(BACK, SUPPLY, OUTLET, CHAMBER, TEMPERATURE, PAST, POSITION, VELOCITY, PRESLIDING,
 PRESSURE_DROP) = range(10)
STATES = 10
STATE_NAMES = ('back_pressure', 'supply_pressure', 'outlet_pressure', 'chamber_pressure',
               'gas_temperature', 'past', 'valve_position', 'stem_velocity', 'presliding_force',
               'pressure_drop')
