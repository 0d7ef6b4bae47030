# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The node `fake_controller`: plays a current profile to a positioner, or closes the position loop.

It waits for a positioner, plays, completes its recordings and ends. `docs/fake_controller.md`
describes parameters, topics and what is recorded.
"""

from collections.abc import Callable, Sequence
import math
from pathlib import Path
import sys
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import try_shutdown
from std_msgs.msg import Float64, String

from ..control.command import make_command
from ..control.selection import select_profile
from ..control.settings import (
    DESCRIPTIONS,
    POSITION,
    SET_POINT,
    ControllerSettings,
    check,
    checked,
)
from ..model.parameters import ParameterError
from ..parameters.sections import files_on
from ..records.record import RecordError
from ..records.recording import Recording
from ..records.target import check_inputs_stay
from ..run_error import RunError
from .current_limits import CurrentLimits
from .declaration import (
    check_files, declare_table, destroyed_if_refused, files_without_section)
from .feedback import Feedback
from .lockstep import Lockstep
from .node_time import NodeTime
from .pace import Pace, RealTime
from .process import run
from .progress import Progress
from .silence import Silence
from .tick_clock import NANOSECONDS

DESCRIPTION = 'Play currents or set points to a positioner, or close its loop, as a ROS 2 node.'
EXAMPLE = '--ros-args --params-file fake_controller.yaml -p record_csv:=record.csv\n' \
    'All parameters: docs/fake_controller.md, or `ros2 param describe` while it runs.'

OUTPUTS = ('chamber_pressure', 'valve_position')

WAITING, PLAYING, DONE = 'waiting', 'playing', 'done'
"""What `~/status` says."""

QUEUE_DEPTH = 10
LOOK_PERIOD = 0.05
WATCH_PERIOD = 0.25
SETTLING = 0.5
"""Seconds before the profile begins, in which a topic just found delivers what had waited."""

DELIVERY_TIMEOUT = Duration(seconds=3)


class FakeController(Node):
    """
    Plays a profile on the node's clock.

    ParameterError for bad parameters; RunError, out of a callback, where the run cannot go on.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        """Check everything; `arguments` is the command line, for the parameter files on it."""
        super().__init__('fake_controller', automatically_declare_parameters_from_overrides=True)
        with destroyed_if_refused(self):
            self._begin(arguments)

    def _begin(self, arguments: Sequence[str]) -> None:
        check_files(arguments, self.get_fully_qualified_name(), checked)
        self._settings: ControllerSettings = declare_table(
            self, DESCRIPTIONS, DESCRIPTIONS.keys(), checked, check)
        profile = select_profile(self._settings)
        self.duration = profile.duration
        self._command = make_command(self._settings, profile)
        self._phase = ''
        self._played = 0.0
        self._current = 0.0
        self._position = math.nan
        self._last_sample = 0
        self._come: set[str] = set()
        self._complete_since: float | None = None
        self._has_gone = False

        self._status = self.create_publisher(
            String, '~/status',
            QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        is_set_point = self._settings.mode == SET_POINT
        self._sent = 'set_point' if is_set_point else 'control_current'
        self._commands = self.create_publisher(Float64, self._sent, QUEUE_DEPTH)
        self._set_points = (
            self.create_publisher(Float64, '~/set_point', QUEUE_DEPTH)
            if self._settings.mode == POSITION else None)
        self._limits = CurrentLimits(self)
        self._time = time = NodeTime(self)
        self._pace = self._make_pace(time)
        self._feedback = Feedback(
            self, time, self._settings.listens_to_stamped, self._on_output)
        self._progress = Progress(self.duration, self.get_logger())
        self._announce(arguments)
        self._recording = self._open_recording(arguments)
        self._enter(WAITING)
        self._steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._waiting_since = self._seconds()
        self._silence = Silence()
        self._clock_seen = -1
        self._look_out = self.create_timer(LOOK_PERIOD, self._on_look, clock=self._steady_clock)

    def _seconds(self) -> float:
        """Return the real time, s."""
        return self._steady_clock.now().nanoseconds / NANOSECONDS

    def _make_pace(self, time: NodeTime) -> Pace:
        settings = self._settings
        if settings.lockstep:
            return Lockstep(self, settings.positioner, settings.rate, self._limits)
        return RealTime(self, time, settings.rate, lambda: self.get_logger().warning(
            'the clock jumped backwards: the profile goes on from where it was'))

    def _open_recording(self, arguments: Sequence[str]) -> Recording:
        settings = self._settings
        topics = {
            name: self.resolve_topic_name(name)
            for name in (self._sent, 'chamber_pressure', 'valve_position')
        }
        inputs = [Path(path) for path in (settings.csv_file, *files_on(arguments)) if path]
        targets = [Path(settings.record_csv)] if settings.record_csv else []
        try:
            check_inputs_stay(inputs, targets, 'record_csv')
            return Recording(
                settings.record_csv, settings.record_bag, settings.bag_format, topics, self._sent)
        except RecordError as error:
            raise ParameterError(f'recording: {error}') from None

    def _announce(self, arguments: Sequence[str]) -> None:
        for path, sections in files_without_section(arguments, self.get_fully_qualified_name()):
            self.get_logger().warning(
                f'{path} holds nothing for {self.get_fully_qualified_name()} '
                f'(its sections: {sections}); `/**:` is for any node')
        values = ', '.join(
            f'{name} {"empty" if value == "" else value}'
            for name, value in self._settings._asdict().items())
        self.get_logger().info(f'parameters in force: {values}')

    def _enter(self, phase: str) -> None:
        self._phase = phase
        self.get_logger().info(phase)
        self._status.publish(String(data=phase))

    # Waiting

    def _on_look(self) -> None:
        in_the_way = self._in_the_way()
        now = self._seconds()
        if not in_the_way:
            self._ask_limits(now)
            if self._complete_since is None:
                self._complete_since = now
            if self._settings.lockstep or (now - self._complete_since >= SETTLING
                                           and not self._limits.awaited(now)):
                self.destroy_timer(self._look_out)
                self._look_out = self.create_timer(
                    WATCH_PERIOD, self._on_watch, clock=self._steady_clock)
                self._pace.begin(self, self._last_sample)
            return
        self._complete_since = None
        if 0.0 < self._settings.wait_timeout < now - self._waiting_since:
            raise RunError(
                'no positioner to play to within wait_timeout '
                f'({self._settings.wait_timeout:g} s): {", ".join(in_the_way)}{self._hint()}')

    def _hint(self) -> str:
        """Return what to do about a positioner that may have the plain topics only."""
        stamped_only = self._needed() and self._settings.listens_to_stamped
        missing = stamped_only and self._feedback.missing_topics()
        return '; feedback: plain listens to topics without a time stamp' if missing else ''

    def _ask_limits(self, now: float) -> None:
        """Ask the positioners for their limits, where their outputs are needed."""
        if self._needed() and not self._settings.lockstep:  # lockstep asks for more at a time
            for name in self._feedback.publishers():
                self._limits.ask(name, now)

    def _in_the_way(self) -> list[str]:
        """Return what keeps the profile from being played."""
        found = self._pace.missing()
        if not self._commands.get_subscription_count():
            found.append(f'nobody subscribes to {self._commands.topic_name}')
        needed = self._needed()
        if needed:
            found += [f'nobody publishes {name}' for name in self._feedback.missing_topics()]
            found += [f'several publish {name}' for name in self._feedback.crowded_topics()]
        if not self._settings.lockstep:  # there an output comes when it is asked for
            found += [f'no {name} has come' for name in needed if name not in self._come]
        return found

    def _needed(self) -> tuple[str, ...]:
        """Return the outputs of the positioner that the run cannot do without."""
        settings = self._settings
        if settings.record_csv or settings.record_bag or settings.lockstep:
            return OUTPUTS
        return ('valve_position',) if settings.mode == POSITION else ()

    # Playing

    def begin(self, stamp: int) -> None:
        """Take note that the profile begins at this stamp, ns."""
        self._recording.start = stamp
        self._silence.excuse(self._seconds())
        self._enter(PLAYING)

    def send(self, played: float, stamp: int) -> None:
        """Send the command for `played` seconds after the start, at a stamp in ns."""
        self._played = played
        self._current = self._command.current(played, self._position)
        self._check_limits()
        self._record(self._recording.sent, self._current, stamp)
        self._commands.publish(Float64(data=self._current))
        if self._set_points is not None:
            self._set_points.publish(Float64(data=self._command.set_point))
        self._progress.show(played)

    def _check_limits(self) -> None:
        """Complain of a current that is not followed; raise if it would falsify a record."""
        if self._settings.mode == SET_POINT:
            return  # the limits are those of currents
        complaint = self._limits.complaint(self._current)
        if complaint and self._recording.paths:
            raise RunError(f'{complaint}, so that it cannot be recorded')
        if complaint:
            self.get_logger().warning(complaint, once=True)

    def repeat(self) -> None:
        """Send the last command again."""
        self._commands.publish(Float64(data=self._current))

    def _on_watch(self) -> None:
        if not self._needed():
            return
        gone, crowded = self._feedback.missing_topics(), self._feedback.crowded_topics()
        if gone:
            self._has_gone = True
            raise RunError(
                f'nobody publishes {" and ".join(gone)} any more: the positioner has gone')
        if crowded:
            raise RunError(
                f'several publish {" and ".join(crowded)} now: their samples cannot be told apart')
        self._check_silence()

    def _check_silence(self) -> None:
        """Raise if the positioner is no longer heard, of which DDS knows only after 20 s."""
        now, shown = self._seconds(), self._time.now()
        if self._time.follows_clock_topic and shown == self._clock_seen:
            self._silence.excuse(now)  # /clock stands still, and the positioner with it
        self._clock_seen = shown
        silence = self._silence.lasts(now)
        if self._phase == PLAYING and silence:
            self._has_gone = True
            raise RunError(_silent(silence))

    def _on_output(self, column: str, value: float, stamp: int) -> None:
        if column == 'valve_position':
            self._position = value
            self._silence.heard(self._seconds())
        self._last_sample = stamp
        self._come.add(column)
        if self._phase != PLAYING:
            return
        own_stamp = self._pace.stamp(column, stamp)
        if own_stamp is not None:
            self._record_output(column, value, own_stamp)

    def _record_output(self, column: str, value: float, stamp: int) -> None:
        self._record(self._recording.received, column, value, stamp)

    def _record(self, note: Callable[..., None], *given: Any) -> None:
        """Note something in the recording; RunError where that cannot be written."""
        try:
            note(*given)
        except RecordError as error:
            raise RunError(f'recording: {error}') from None

    # The end

    def finish(self) -> None:
        """Complete the recording, say so, and end unless told to stay."""
        self._progress.show(self.duration)
        self._phase = DONE  # whatever comes of closing, it is not tried twice
        self.destroy_timer(self._look_out)
        silence = self._silence.lasts(self._seconds()) if self._needed() else 0.0
        self._end_recording(self._recording.close_early if silence else self._recording.close)
        if self._recording.paths:
            partial = 'partial: ' if silence else ''
            self.get_logger().info(f'{partial}{self._recorded()}')
        if silence:
            raise RunError(_silent(silence))
        self._enter(DONE)
        if not self._settings.keep_alive:
            self._status.wait_for_all_acked(DELIVERY_TIMEOUT)
            try_shutdown(context=self.context)

    def _end_recording(self, end: Callable[[], None]) -> None:
        self._progress.close()
        try:
            end()
        except RecordError as error:
            raise RunError(f'recording: {error}') from None

    def _recorded(self) -> str:
        if not self._recording.rows:
            return 'nothing recorded'
        paths = ' and '.join(map(str, self._recording.paths))
        return f'{self._recording.rows} samples recorded to {paths}'

    def destroy_node(self) -> None:
        """Complete a recording that has been interrupted, remove one that has not begun."""
        # The node's own logger also publishes, which it no longer can.
        logger = get_logger(f'{self.get_logger().name}.end')
        if self._phase == WAITING:
            self._recording.discard()
        elif self._phase == PLAYING:
            self._end_recording(self._recording.close_early)
            partial = f'; partial: {self._recorded()}' if self._recording.paths else ''
            logger.warning(
                f'interrupted after {self._played:.2f} of {self.duration:g} s{partial}')
        left_behind = '' if self._phase == DONE or self._has_gone else self._pace.left_behind()
        if left_behind:
            logger.warning(left_behind)
        super().destroy_node()


def _silent(seconds: float) -> str:
    return (f'nothing has come from the positioner in the last {seconds:.1f} s (it has ended, '
            'hangs or is paused): what was played then drove nothing')


def main(args: Sequence[str] | None = None) -> int:
    """Run the node; `args` is the command line without the program's name."""
    arguments = sys.argv[1:] if args is None else list(args)
    return run(
        'fake_controller', DESCRIPTION, lambda: FakeController(arguments), arguments, EXAMPLE)


if __name__ == '__main__':
    sys.exit(main())
