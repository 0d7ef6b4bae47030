# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the positioner publishes at every tick, and as which messages."""

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from ..model.gas import ATMOSPHERE
from ..model.system import OUTPUT_UNITS, Outputs
from .tick_clock import NANOSECONDS

JOINT_NAME = 'valve_stem'
QUEUE_DEPTH = 1000
"""Messages kept for a reliable subscription that missed them: ~/step publishes in bursts."""


def stamp_message(nanoseconds: int) -> Time:
    """Return a time stamp from nanoseconds."""
    seconds, rest = divmod(nanoseconds, NANOSECONDS)
    return Time(sec=seconds, nanosec=rest)


class OutputPublishers:
    """
    The publishers of the outputs.

    The messages are made once and filled in anew at each tick. The two contract topics are always
    published; the others only while somebody listens, since most of the time nobody does.
    """

    def __init__(self, node: Node) -> None:
        """Create the publishers with reliable, volatile QoS, which any subscription can read."""
        self._pressure = node.create_publisher(Float64, 'chamber_pressure', QUEUE_DEPTH)
        self._position = node.create_publisher(Float64, 'valve_position', QUEUE_DEPTH)
        self._stamped_pressure = node.create_publisher(
            FluidPressure, 'chamber_pressure_stamped', QUEUE_DEPTH)
        self._stamped_position = node.create_publisher(
            JointState, 'valve_position_stamped', QUEUE_DEPTH)
        self._state = node.create_publisher(DiagnosticArray, '~/state', QUEUE_DEPTH)
        self._frame = node.get_name()
        self._values = [KeyValue(key=name) for name in Outputs._fields]
        self._status = DiagnosticStatus(
            level=DiagnosticStatus.OK, name='state', values=self._values,
            message=', '.join(f'{name} {unit}' for name, unit in OUTPUT_UNITS.items()))

    def publish(self, outputs: Outputs, nanoseconds: int) -> None:
        """Publish the outputs of the tick that lies at this time of the node's clock."""
        pressure = outputs.measured_chamber_pressure
        position = outputs.measured_valve_position
        self._pressure.publish(Float64(data=pressure))
        self._position.publish(Float64(data=position))
        header = Header(stamp=stamp_message(nanoseconds), frame_id=self._frame)
        if self._stamped_pressure.get_subscription_count():
            self._stamped_pressure.publish(
                FluidPressure(header=header, fluid_pressure=pressure + ATMOSPHERE))
        if self._stamped_position.get_subscription_count():
            self._stamped_position.publish(JointState(
                header=header, name=[JOINT_NAME], position=[position],
                velocity=[outputs.stem_velocity]))
        if self._state.get_subscription_count():
            for entry, value in zip(self._values, outputs, strict=True):
                entry.value = repr(value)
            self._state.publish(DiagnosticArray(header=header, status=[self._status]))
