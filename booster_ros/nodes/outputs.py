# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the positioner publishes at every tick, and as which messages."""

from collections.abc import Callable, Mapping
import math

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from ..model.gas import ATMOSPHERE
from ..model.outputs import OUTPUT_UNITS, Outputs
from .tick_clock import NANOSECONDS

QUEUE_DEPTH = 1000
"""Messages kept for a reliable subscription that missed them: ~/step publishes in bursts."""


def stamp_message(nanoseconds: int) -> Time:
    """Return a time stamp from nanoseconds."""
    seconds, rest = divmod(nanoseconds, NANOSECONDS)
    return Time(sec=seconds, nanosec=rest)


def are_finite(readings: tuple[float, float]) -> bool:
    """Tell whether readings are finite numbers."""
    return all(map(math.isfinite, readings))


def quiet_publisher(node: Node, kind: type, topic: str) -> Publisher:
    """
    Return a publisher that does not watch for subscriptions whose QoS does not fit.

    Each watch is one more thing that the executor asks about at every tick, and a reliable,
    volatile publisher fits all but exotic subscriptions.
    """
    return node.create_publisher(
        kind, topic, QUEUE_DEPTH,
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))


class OutputPublishers:
    """
    The publishers of the outputs.

    Pressure and position as plain numbers are always published; the other topics only while
    somebody listens, since most of the time nobody does.
    """

    def __init__(self, node: Node, joint: str, frame: str) -> None:
        """Create the publishers with reliable, volatile QoS, which any subscription can read."""
        self._joint, self._frame = joint, frame
        self._pressure = quiet_publisher(node, Float64, 'chamber_pressure')
        self._position = quiet_publisher(node, Float64, 'valve_position')
        self.always_published = (self._pressure, self._position)
        self._heard_only = (
            (quiet_publisher(node, FluidPressure, 'chamber_pressure_stamped'), self._pressure_of),
            (quiet_publisher(node, JointState, 'valve_position_stamped'), self._position_of),
            (quiet_publisher(node, DiagnosticArray, '~/state'), self._state_of),
        )
        self.set_point: float | None = None
        """The set point in force, m, where one is commanded."""
        self.faults: Mapping[str, float] = {}
        """The faults that are on, with their shares of full strength."""
        self._faults = DiagnosticStatus(level=DiagnosticStatus.OK, name='faults')
        self._values = [KeyValue(key=name) for name in Outputs._fields]
        self._status = DiagnosticStatus(
            level=DiagnosticStatus.OK, name='state', values=self._values,
            message=', '.join(f'{name} {unit}' for name, unit in OUTPUT_UNITS.items()))

    def listeners(self) -> int:
        """Return how many subscriptions there are to outputs."""
        publishers = (*self.always_published, *(publisher for publisher, _ in self._heard_only))
        return sum(publisher.get_subscription_count() for publisher in publishers)

    def publish(
        self, outputs: Callable[[], Outputs], readings: tuple[float, float], nanoseconds: int,
        thinned: bool = False,
    ) -> None:
        """
        Publish the outputs of the tick that lies at this time of the node's clock.

        `readings` are what the sensors show, Pa gauge and m. Of a tick that is `thinned` there
        are the plain numbers only.
        """
        pressure, position = readings
        self._pressure.publish(Float64(data=pressure))
        self._position.publish(Float64(data=position))
        if thinned:
            return
        for publisher, message in self._heard_only:
            if publisher.get_subscription_count():
                seen = outputs()._replace(
                    measured_chamber_pressure=pressure, measured_valve_position=position)
                publisher.publish(message(seen, self._header(nanoseconds)))

    def _header(self, nanoseconds: int) -> Header:
        return Header(stamp=stamp_message(nanoseconds), frame_id=self._frame)

    def _pressure_of(self, outputs: Outputs, header: Header) -> FluidPressure:
        return FluidPressure(
            header=header, fluid_pressure=outputs.measured_chamber_pressure + ATMOSPHERE)

    def _position_of(self, outputs: Outputs, header: Header) -> JointState:
        return JointState(
            header=header, name=[self._joint], position=[outputs.measured_valve_position],
            velocity=[outputs.stem_velocity])

    def _state_of(self, outputs: Outputs, header: Header) -> DiagnosticArray:
        for entry, value in zip(self._values, outputs, strict=True):
            entry.value = repr(value)
        if self.set_point is not None:
            set_point = KeyValue(key='set_point', value=repr(self.set_point))
            self._status.values = [*self._values, set_point]
        self._faults.message = ', '.join(self.faults)
        self._faults.values = [
            KeyValue(key=name, value=repr(share)) for name, share in self.faults.items()]
        return DiagnosticArray(header=header, status=[self._status, self._faults])
