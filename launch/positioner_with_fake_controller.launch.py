# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Start one positioner and the fake controller that drives it; ends when the profile is played."""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Add a controller to positioner.launch.py, whose arguments hold here as well."""
    share = FindPackageShare('booster_ros')
    return LaunchDescription(
        [
            IncludeLaunchDescription(
                PathJoinSubstitution([share, 'launch', 'positioner.launch.py'])
            ),
            DeclareLaunchArgument(
                'controller_params_file',
                default_value=PathJoinSubstitution([share, 'config', 'fake_controller.yaml']),
                description='ROS 2 parameter file of the fake controller',
            ),
            Node(
                package='booster_ros',
                executable='fake_controller',
                name='fake_controller',
                namespace=LaunchConfiguration('namespace'),
                # not among `parameters`: a file that is not there would be passed over
                ros_arguments=[
                    '--params-file', LaunchConfiguration('controller_params_file'),
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
            # whichever ends first: the profile has been played, or there is nobody to play it to
            RegisterEventHandler(OnProcessExit(on_exit=[Shutdown(reason='one of the two ended')])),
        ]
    )
