# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The catalogue of effects: what real positioners have and the declared model lacks.

An effect is a row here and a few parameters in the component where its physics lives. Everything
that searches, fits, reports or configures effects reads these rows.
"""

from .actuator import VESSEL
from .booster import NO_BOOSTER
from .effect import Effect, Knob
from .gas import ISO_6358
from .position_controller import CONTINUOUS, PULSES, PositionController
from .system import PositionerParameters


def _effect(name, location, meaning, needs, experiment, source, *knobs: Knob,
            loosens: tuple[str, ...] = (), reading: str = '', orifice_law: int | None = None,
            driven_by: str = '') -> Effect:
    return Effect(
        name, location, knobs, meaning, needs, experiment, source, loosens, reading, orifice_law,
        driven_by)


def _firmware(name: str, meaning: str, **sets: float) -> Effect:
    """Return the effect that a positioner has another control law, tuned in its own way."""
    return Effect(
        name, 'position_controller', (
            Knob('position_controller.gain_change', 0.7, -4.605, 4.605),
            Knob('position_controller.integral_time_change', 0.7, -2.303, 2.303, clocked=True)),
        f'the positioner has another firmware than declared: {meaning}', 'steps',
        "read the positioner's type and settings", 'control laws of smart positioners: IEC 61514-2',
        sets=tuple((f'position_controller.{parameter}', value)
                   for parameter, value in sets.items()))


_SLIDING = Knob('actuator.coulomb_friction', 300.0, 0.0, 6e3, rubs=True)
# a packing stiffer than `high` yields less than sensors tell: a rigid one reads the same, and is
# simulated faster
_PRESLIDING = Knob('actuator.presliding_stiffness', 1e7, 1e6, 1e8, 0.0, inverse=1, shape=True)
_PRESLIDING_DAMPING = Knob(
    'actuator.presliding_damping', 1.0, 0.2, 3.0, 1.0, shape=True, clocked=True)

_ROWS = (
    _effect(
        'ep_hysteresis', 'ep_converter', 'the back pressure lags behind a reversing current',
        'reversals of the current', 'slow triangle with the back pressure recorded: the loop '
        'stands in back pressure over current',
        'play operator: A. Visintin, Differential Models of Hysteresis, 1994',
        Knob('ep_converter.hysteresis', 2e-6, 0.0, 1e-4, departs='ep_play')),
    _effect(
        'ep_drift', 'ep_converter', 'the back pressure shifts with time (coil heating)',
        'minutes of record', 'repeat one step after an hour: the settled pressure has moved',
        'first-order warming of coil and magnet',
        Knob('ep_converter.drift', 1e3, -1e5, 1e5, clocked=True),
        Knob('ep_converter.drift_time_constant', 100.0, 5.0, 1e4, 100.0, shape=True)),
    _effect(
        'ep_nonlinearity', 'ep_converter', 'the back pressure is not a straight line over current',
        'settled pressures across the range', 'staircase with the back pressure recorded',
        'second and third order of the nozzle-flapper characteristic',
        Knob('ep_converter.nonlinearity_even', 1e3, -1e5, 1e5),
        Knob('ep_converter.nonlinearity_odd', 1e3, -1e5, 1e5),
        # gain and zero were adjusted to a straight line, which this curve need not touch at its
        # centre, where its terms are 0
        loosens=('ep_converter.gain', 'ep_converter.offset')),
    _effect(
        'dead_time', 'ep_converter', 'the response starts late', 'steps, sampled faster than it',
        'steps of several sizes: a delay shifts all by the same time',
        'pure delay: E. Richer, Y. Hurmuzlu, J. Dyn. Sys. Meas. Control 122 (2000) 416',
        Knob('ep_converter.dead_time', 0.05, 0.0, 5.0, clocked=True)),
    _effect(
        'ep_gain_loss', 'ep_converter', 'the back pressure is lower or higher in proportion to the '
        'current, beyond the tolerance of the gain',
        'settled pressures at several currents', 'staircase with the back pressure recorded: a '
        'straight line of another slope through the same zero',
        'a share of the current; M. Bartys et al., Control Eng. Practice 14 (2006) 577, f12',
        Knob('ep_converter.gain_loss', 0.1, -2.0, 0.95)),
    _effect(
        'booster_dead_band', 'booster', 'force before intake or exhaust opens',
        'reversals, or the back pressure', 'slow triangle with the stem blocked: the dead band '
        'stays', 'paper Table I: flow begins at about 0.37 N',
        Knob('booster.intake_preload', 0.02, 0.0, 1.0),
        Knob('booster.exhaust_preload', 0.02, 0.0, 1.0)),
    _effect(
        'exhaust_asymmetry', 'booster', 'the exhaust opens differently from the intake',
        'steps up and down', 'equal steps up and down over the same span',
        'separate width and lift of the exhaust seat',
        Knob('booster.exhaust_gain_ratio', 0.7, 0.1, 8.0, 1.0),
        Knob('booster.exhaust_lift_ratio', 0.7, 0.1, 8.0, 1.0)),
    _effect(
        'supply_seat_leak', 'booster', 'the intake seat never closes',
        'settled pressures', 'dead-ended hold: the pressure rises with the booster closed',
        'ISO 6358 orifice that is always open', Knob('booster.supply_leak_area', 5e-8, 0.0, 1e-6)),
    _effect(
        'opening_nonlinearity', 'booster', 'the opening is not proportional to the force',
        'steps of several sizes', 'free-flow bench: flow over force at one supply pressure',
        'power law and p-norm knee',
        Knob('booster.opening_exponent', 1.3, 0.4, 3.0, 1.0),
        Knob('booster.knee_softness', 0.3, 0.0, 1.0)),
    _effect(
        'plug_flow_force', 'booster', 'the jet pushes the plug closed',
        'several supply or chamber pressures', 'free-flow bench at several supply and outlet '
        'pressures', 'paper Table I; J. F. Blackburn et al., Fluid Power Control, 1960, ch. 10',
        Knob('booster.intake_flow_force', 0.7, 0.0, 10.0),
        Knob('booster.exhaust_flow_force', 0.7, 0.0, 10.0)),
    _effect(
        'critical_pressure_ratio', 'booster', 'real seats choke at another pressure ratio',
        'fills to high pressure', 'fill to different fractions of the supply pressure',
        'ISO 6358-1: b of real seats is 0.15 to 0.45',
        Knob('booster.critical_pressure_ratio_shift', -0.15, -0.5, 0.4), orifice_law=ISO_6358),
    _effect(
        'supply_droop', 'supply', 'the regulator loses pressure with flow',
        'large steps', 'log the supply pressure during a large step',
        'regulator characteristic, ISO 6953-1',
        Knob('supply.droop', 2e7, 0.0, 1e9),
        Knob('supply.droop_time_constant', 0.1, 0.01, 10.0, 0.1, shape=True)),
    _effect(
        'supply_ripple', 'supply', 'the supply pressure oscillates',
        'rests longer than its period', 'log the supply pressure at rest',
        'sinusoidal or saw-toothed supply pressure',
        Knob('supply.ripple', 2e3, 0.0, 1e5, clocked=True),
        Knob('supply.ripple_frequency', 0.5, 0.003, 20.0, 0.5, shape=True, frequency=True),
        Knob('supply.ripple_phase', 0.0, -7.0, 7.0, shape=True, phase=True),
        Knob('supply.ripple_skew', 0.0, -0.95, 0.95, shape=True)),
    _effect(
        'tubing_restriction', 'tubing', 'tube and fittings throttle between booster and actuator',
        'steps', 'two pressure taps, at the booster outlet and at the actuator',
        'ISO 6358 orifice and laminar flow behind a volume',
        Knob('tubing.restriction_area', 2e-6, 2e-8, 3e-5, 0.0, inverse=2),
        Knob('tubing.outlet_volume', 4e-5, 2e-6, 2e-3, 4e-5, shape=True, tried=(1e-5, 4e-5)),
        Knob('tubing.laminar_share', 0.0, 0.0, 1.0, 0.0, shape=True, tried=(0.0, 1.0))),
    _effect(
        'chamber_leak', 'chamber', 'air escapes from the actuator', 'settled pressures, steps',
        'valve the actuator off and watch its pressure for minutes',
        'ISO 6358 orifice; M. Bartys et al., Control Eng. Practice 14 (2006) 577, f9, f10',
        Knob('actuator.leak_area', 5e-8, 0.0, 1e-4)),
    _effect(
        'exhaust_seat_leak', 'booster', 'the exhaust seat never closes',
        'settled pressures', 'hold with the tube valved off at the actuator: the chamber holds, '
        'the air consumption stays', 'ISO 6358 orifice that is always open',
        Knob('booster.exhaust_leak_area', 5e-8, 0.0, 1e-6)),
    _effect(
        'heat_transfer', 'chamber', 'the air warms when compressed and cools at the wall',
        'fast fills followed by rests', 'blocked stem, fast fill, then isolate: the pressure '
        'relaxes to a plateau', 'first law for an ideal gas with heat through the wall',
        Knob('actuator.thermal_resistance', 0.3, 0.0, 500.0, clocked=True, departs='temperature')),
    _effect(
        'dead_volume_change', 'chamber', 'the chamber is larger or smaller than declared',
        'steps below and above the bench set', 'blocked-stem fills with a known volume added',
        'chamber volume at closed stem', Knob('actuator.added_volume', 1e-4, -1.5e-4, 3e-3)),
    _effect(
        'stem_friction', 'stem', 'packing friction: the stem sticks and slips',
        'reversals', 'slow triangle: two parallel lines in position over pressure; dither '
        'narrows them', 'B. Armstrong-Helouvry et al., Automatica 30 (1994) 1083',
        _SLIDING,
        Knob('actuator.stiction', 100.0, 0.0, 3e3, clocked=True),
        _PRESLIDING, _PRESLIDING_DAMPING,
        Knob('actuator.stribeck_velocity', 1e-3, 3e-4, 1e-2, 1e-3, shape=True, clocked=True)),
    _effect(
        'position_dependent_friction', 'stem',
        'friction differs along the travel (bent or galled stem)',
        'reversals at several positions', 'valve signature over the full travel',
        'M. Bartys et al., Control Eng. Practice 14 (2006) 577, f8; the peak: assumed shape',
        _SLIDING,
        Knob('actuator.friction_gradient', 300.0, -6e3, 6e3),
        Knob('actuator.friction_peak', 300.0, 0.0, 6e3),
        Knob('actuator.friction_peak_position', 8e-3, 0.0, 1.6e-2, 8e-3, shape=True),
        Knob('actuator.friction_peak_width', 2e-3, 5e-4, 1e-2, 2e-3, shape=True),
        _PRESLIDING, _PRESLIDING_DAMPING),
    _effect(
        'spring_nonlinearity', 'stem', 'the spring is not a straight line',
        'positions across the travel', 'spring test without the diaphragm',
        'slope, bow and S-curve beside the straight spring',
        Knob('actuator.spring_bend', 300.0, -5e3, 5e3),
        Knob('actuator.spring_s_curve', 100.0, -5e3, 5e3),
        Knob('actuator.spring_excess', 300.0, -5e3, 5e3)),
    _effect(
        'effective_area_change', 'stem', 'the diaphragm area falls over the travel',
        'positions across the travel', 'spring test without the diaphragm',
        'diaphragm area linear in travel',
        Knob('actuator.area_change', 0.05, -0.5, 0.5)),
    _effect(
        'bench_set_shift', 'stem', 'the spring is preloaded differently from declared',
        'moving stem',
        'bench test: the pressures at which the stem leaves 0 and reaches the travel',
        'bench set, IEC 60534', Knob('actuator.bench_set_shift', 5e3, -2e5, 2e5)),
    _effect(
        'spring_rate_change', 'stem', 'the spring is softer or stiffer as a whole, its preload '
        'included', 'positions across the travel',
        'bench test: both pressures of the bench set are off by the same share',
        'M. Bartys et al., Control Eng. Practice 14 (2006) 577, f11',
        Knob('actuator.spring_loss', 0.1, -2.0, 0.95)),
    _effect(
        'stem_damping', 'stem', 'a force in proportion to its speed holds the stem back beyond '
        'what is declared (snubber, damper)', 'steps',
        'ramps of several speeds: position lags behind pressure in proportion to the speed, and '
        'not at an end stop', 'viscous damper',
        Knob('actuator.added_damping', 1e5, 0.0, 2e7, clocked=True)),
    _effect(
        'travel_limit', 'stem', 'the stem stops before the ends of its travel',
        'strokes to both ends', 'full strokes: the pressure goes on, the position does not',
        'end stop at another place; M. Bartys et al., Control Eng. Practice 14 (2006) 577, f1',
        Knob('actuator.upper_travel_lost', 0.1, 0.0, 0.95),
        Knob('actuator.lower_travel_lost', 0.1, 0.0, 0.95)),
    _effect(
        'seat_load', 'stem', 'the seat yields to, holds or pushes the nearly closed stem',
        'closing and opening', 'valve signature near the seat',
        'soft seat that yields and lets go linearly',
        Knob('actuator.seat_load', 500.0, -1e4, 1e4),
        Knob('actuator.seat_depth', 1e-3, 1e-4, 6e-3, 1e-3, shape=True),
        Knob('actuator.seat_stiffness', 3e7, 6e6, 1e10, inverse=1)),
    _effect(
        'flow_force', 'stem', 'the process pushes on the plug',
        'positions across the travel', 'the same strokes without process pressure',
        'unbalanced plug: force falls as the valve opens',
        Knob('actuator.flow_force', 500.0, -1e4, 1e4),
        Knob('actuator.flow_force_decay', 0.3, 0.05, 3.0, 0.3, shape=True)),
    _effect(
        'process_force', 'stem', 'the pressure drop over the process valve pushes on the plug',
        'a recorded pressure drop that changes',
        'the same strokes at several pressure drops: the pressure that holds a position moves in '
        'proportion to the drop',
        'unbalanced plug; M. Bartys et al., Control Eng. Practice 14 (2006) 577, vena contracta '
        'force',
        Knob('actuator.plug_area', 1e-3, -0.02, 0.02, goes_with='N/Pa'),
        driven_by='pressure_drop'),
    _effect(
        'slew_limit', 'position_controller', 'the valve follows the set point no faster than at a '
        'certain speed, which may differ up and down',
        'steps up and down, larger than what it moves from row to row',
        'steps of several sizes, up and down: the times grow with the size',
        'rate limits of smart positioners: IEC 61514-2',
        Knob('position_controller.rate_limit_up', 3e-3, 1e-5, 0.2, 0.0, inverse=1, clocked=True),
        Knob('position_controller.rate_limit_down', 3e-3, 1e-5, 0.2, 0.0, inverse=1,
             clocked=True)),
    _effect(
        'positioner_dead_zone', 'position_controller',
        'the positioner leaves a larger error as it is than declared',
        'small steps, reversals', 'read the dead zone that is set in the positioner; with the '
        'pressure recorded: within it the pressure stands',
        'dead zone of smart positioners: IEC 61514-2',
        Knob('position_controller.added_dead_zone', 1e-4, 0.0, 2e-3)),
    _effect(
        'feedback_backlash', 'position_controller',
        'lost motion in the linkage through which the positioner sees the stem',
        'reversals, read by a sensor apart from that of the positioner',
        'hold the feedback lever by hand: the valve moves while it does not',
        'play operator; M. Bartys et al. (2006), f15',
        Knob('position_controller.feedback_backlash', 1e-4, 0.0, 5e-3)),
    _effect(
        'positioner_tuning', 'position_controller',
        'the positioner is tuned otherwise than declared: it oscillates or creeps', 'steps',
        'read gain and integral time that are set in the positioner',
        'gain and integral time within a factor of ten either way',
        Knob('position_controller.gain_change', 0.7, -2.303, 2.303),
        Knob('position_controller.integral_time_change', 0.7, -2.303, 2.303, clocked=True)),
    _firmware(
        'proportional_firmware', 'it is proportional, with velocity feedback',
        output=CONTINUOUS, gain=0.3, integral_time=0.0, derivative_time=0.03),
    _firmware(
        'integrating_firmware', 'it has an integral part',
        output=CONTINUOUS, gain=0.17, integral_time=4.2, derivative_time=0.0),
    _firmware(
        'pulsing_firmware', 'it moves the valve by pulses',
        output=PULSES, gain=5e-3, integral_time=0.0, derivative_time=0.2, least_pulse=2e-4),
    _effect(
        'position_backlash', 'sensor', 'lost motion in the feedback linkage',
        'reversals', 'a second position sensor on the stem',
        'play operator; M. Bartys et al. (2006), f15',
        Knob('sensors.position_backlash', 1e-4, 0.0, 5e-3, departs='position_play'),
        reading='valve_position'),
    _effect(
        'position_sensor_lag', 'sensor', 'the position reading comes late', 'steps',
        'a second position sensor on the stem', 'first-order sensor',
        Knob('sensors.position_lag', 0.1, 0.0, 20.0, clocked=True), reading='valve_position'),
    _effect(
        'position_sensor_bias', 'sensor', 'the position reading is off in zero or span',
        'rest at an end stop', 'both end stops', 'zero and span error, IEC 61298-2',
        Knob('sensors.position_bias', 1e-4, -5e-3, 5e-3),
        Knob('sensors.position_span_error', 0.02, -0.5, 0.5), reading='valve_position'),
    _effect(
        'pressure_sensor_lag', 'sensor', 'the pressure reading comes late', 'steps',
        'a second pressure sensor at the chamber', 'first-order sensor',
        Knob('sensors.pressure_lag', 0.1, 0.0, 20.0, clocked=True), reading='chamber_pressure'),
    _effect(
        'pressure_sensor_bias', 'sensor', 'the pressure reading is off in zero or span',
        'vented chamber, settled pressures', 'vent the chamber: the reading must be zero; then '
        'fill it to a pressure that is known', 'zero and span error, IEC 61298-2',
        Knob('sensors.pressure_bias', 3e3, -2e5, 2e5),
        Knob('sensors.pressure_span_error', 0.02, -0.5, 0.5), reading='chamber_pressure'),
)

EFFECTS: dict[str, Effect] = {row.name: row for row in _ROWS}
"""All named effects; the names and locations are those that reports print."""

_OF_EFFECTS = frozenset(knob.parameter for row in _ROWS for knob in row.knobs) | {
    # parameters of effects that no fit turns
    'ep_converter.nonlinearity_centre', 'ep_converter.nonlinearity_span',
    'tubing.critical_pressure_ratio',
}


def is_of_effect(parameter: str) -> bool:
    """
    Tell whether a parameter (dotted name) belongs to an effect, or to the term without a name.

    The others belong to the declared model: the model that is left where the parameters of all
    effects have their defaults.
    """
    return parameter in _OF_EFFECTS or parameter.startswith('discrepancy.')


def is_optional(parameter: str) -> bool:
    """Tell whether a parameter goes without saying at its default: of an effect, or of a loop."""
    return is_of_effect(parameter) or parameter.startswith('position_controller.')


def _firmware_of(c: PositionController) -> str:
    """Return the name of the effect that a positioner of another kind has this control law."""
    if c.output == PULSES:
        return 'pulsing_firmware'
    return 'integrating_firmware' if c.integral_time > 0.0 else 'proportional_firmware'


def has_part(p: PositionerParameters, effect: Effect) -> bool:
    """Tell whether a rig has what an effect is in: the booster, or the stem and its sensor."""
    if effect.sets:
        return effect.name != _firmware_of(p.position_controller)
    if effect.location == 'booster':
        return p.booster.kind != NO_BOOSTER
    if effect.location == 'stem' or effect.reading == 'valve_position':
        return p.actuator.kind != VESSEL
    return True


__all__ = ['EFFECTS', 'Effect', 'Knob', 'has_part', 'is_of_effect', 'is_optional']
