# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Start one positioner: ros2 launch booster_ros positioner.launch.py namespace:=valve_7."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments (``ros2 launch … --show-args`` lists them) and start the node."""
    default_params = PathJoinSubstitution(
        [FindPackageShare('booster_ros'), 'config', 'positioner.yaml']
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'params_file',
                default_value=default_params,
                description='ROS 2 parameter file of the positioner',
            ),
            DeclareLaunchArgument(
                'namespace', default_value='', description='namespace of the node and its topics'
            ),
            DeclareLaunchArgument(
                'log_level',
                default_value='info',
                choices=['debug', 'info', 'warn', 'error', 'fatal'],
                description='least severity of what nodes log',
            ),
            DeclareLaunchArgument(
                'use_sim_time',
                default_value='false',
                choices=['true', 'false'],
                description='true: simulated seconds follow /clock',
            ),
            Node(
                package='booster_ros',
                executable='positioner',
                name='positioner',
                namespace=LaunchConfiguration('namespace'),
                # not among `parameters`: a file that is not there would be passed over
                ros_arguments=[
                    '--params-file', LaunchConfiguration('params_file'),
                    '--log-level', LaunchConfiguration('log_level'),
                ],
                parameters=[
                    {
                        'use_sim_time': ParameterValue(
                            LaunchConfiguration('use_sim_time'), value_type=bool
                        )
                    }
                ],
                output='screen',
            ),
        ]
    )
