# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Start a positioner that plays the real valve, moves it, and the twin beside it.

After two minutes its packing begins to rub; the twin says so, has that diagnosed, and adopts what
is found if it is confirmed.

ros2 launch booster_ros twin.launch.py faults:='[{fault: f8, at: 120.0}]'
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the three nodes."""
    share = FindPackageShare('booster_ros')
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'params_file',
                default_value=PathJoinSubstitution([share, 'config', 'positioner.yaml']),
                description='ROS 2 parameter file of the valve, and of the model beside it',
            ),
            DeclareLaunchArgument(
                'twin_params_file',
                default_value=PathJoinSubstitution([share, 'config', 'twin.yaml']),
                description='ROS 2 parameter file of the twin',
            ),
            DeclareLaunchArgument(
                'log_level',
                default_value='info',
                choices=['debug', 'info', 'warn', 'error', 'fatal'],
                description='least severity of what nodes log',
            ),
            DeclareLaunchArgument(
                'faults',
                default_value='[{fault: stem_friction, strength: 1.0, at: 130.0}]',
                description='timetable of faults: docs/faults.md',
            ),
            DeclareLaunchArgument(
                'reports',
                default_value='twin_reports',
                description='folder of the reports of diagnoses',
            ),
            DeclareLaunchArgument(
                'memory',
                default_value='',
                description='file of what is known again after a restart, none by default',
            ),
            DeclareLaunchArgument(
                'hypotheses',
                default_value='stem_friction position_backlash chamber_leak bench_set_shift',
                description="effects that a diagnosis tries, '' for all, which takes minutes",
            ),
            DeclareLaunchArgument(
                'history', default_value='40.0', description='seconds of a record to diagnose'
            ),
            DeclareLaunchArgument(
                'trial', default_value='20.0', description='seconds of a trial of a found model'
            ),
            DeclareLaunchArgument(
                'learning', default_value='90.0', description='seconds in which the twin learns'
            ),
            DeclareLaunchArgument(
                'block', default_value='0.5', description='seconds that are judged as one'
            ),
            DeclareLaunchArgument(
                'adopt_confirmed',
                default_value='true',
                choices=['true', 'false'],
                description='whether a found model is adopted without a call of ~/adopt',
            ),
            Node(
                package='booster_ros',
                executable='positioner',
                name='positioner',
                # not among `parameters`: a file that is not there would be passed over
                ros_arguments=[
                    '--params-file', LaunchConfiguration('params_file'),
                    '--log-level', LaunchConfiguration('log_level'),
                ],
                parameters=[
                    {
                        'faults.timetable': ParameterValue(
                            LaunchConfiguration('faults'), value_type=str
                        ),
                        'measurement.pressure_noise': 150.0,
                        'measurement.position_noise': 8e-6,
                    }
                ],
                output='screen',
            ),
            Node(
                package='booster_ros',
                executable='fake_controller',
                name='fake_controller',
                ros_arguments=['--log-level', LaunchConfiguration('log_level')],
                parameters=[
                    {
                        'profile': 'sines', 'loop': True, 'frequencies': [0.21, 0.55, 0.83],
                        'low': 0.425e-3, 'high': 0.441e-3,
                    }
                ],
                output='screen',
            ),
            Node(
                package='booster_ros',
                executable='twin',
                name='twin',
                ros_arguments=[
                    '--params-file', LaunchConfiguration('twin_params_file'),
                    '--log-level', LaunchConfiguration('log_level'),
                ],
                parameters=[
                    {
                        'model': LaunchConfiguration('params_file'),
                        'learning': ParameterValue(
                            LaunchConfiguration('learning'), value_type=float
                        ),
                        'block': ParameterValue(LaunchConfiguration('block'), value_type=float),
                        'reports': ParameterValue(LaunchConfiguration('reports'), value_type=str),
                        'memory': ParameterValue(LaunchConfiguration('memory'), value_type=str),
                        'hypotheses': ParameterValue(
                            LaunchConfiguration('hypotheses'), value_type=str
                        ),
                        'history': ParameterValue(
                            LaunchConfiguration('history'), value_type=float
                        ),
                        'trial': ParameterValue(LaunchConfiguration('trial'), value_type=float),
                        'adopt_confirmed': ParameterValue(
                            LaunchConfiguration('adopt_confirmed'), value_type=bool
                        ),
                        'rate': 4.0,
                    }
                ],
                output='screen',
            ),
        ]
    )
