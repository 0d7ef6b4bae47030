# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Start two positioners side by side, each in its own namespace."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Include positioner.launch.py twice; params_file, log_level and use_sim_time hold for both."""
    actions = []
    for argument, default in (('first_namespace', 'valve_1'), ('second_namespace', 'valve_2')):
        actions += [
            DeclareLaunchArgument(argument, default_value=default, description='namespace'),
            # A group of its own, so that the namespace of one does not reach the other.
            GroupAction(
                [
                    IncludeLaunchDescription(
                        PathJoinSubstitution(
                            [FindPackageShare('booster_ros'), 'launch', 'positioner.launch.py']
                        ),
                        launch_arguments={'namespace': LaunchConfiguration(argument)}.items(),
                    )
                ]
            ),
        ]
    return LaunchDescription(actions)
