# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Start two positioners side by side, each in its own namespace."""

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
)
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Include positioner.launch.py twice; params_file, log_level and use_sim_time hold for both."""
    share = FindPackageShare('booster_ros')
    actions = [
        DeclareLaunchArgument(
            'params_file',
            default_value=PathJoinSubstitution([share, 'config', 'positioner.yaml']),
            description='ROS 2 parameter file of both positioners',
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
    ]
    for argument, default in (('first_namespace', 'valve_1'), ('second_namespace', 'valve_2')):
        actions += [
            DeclareLaunchArgument(
                argument,
                default_value=default,
                description='namespace of one positioner and its topics',
            ),
            # A group of its own, so that the namespace of one does not reach the other.
            GroupAction([OpaqueFunction(function=_positioner, args=[argument])]),
        ]
    return LaunchDescription(actions)


def _positioner(context: LaunchContext, argument: str) -> list:
    """
    Include positioner.launch.py with the namespace that an argument of this file gives.

    Included while launching, as ``--show-args`` would list its argument ``namespace`` otherwise,
    which does nothing here.
    """
    launch_file = PathJoinSubstitution(
        [FindPackageShare('booster_ros'), 'launch', 'positioner.launch.py']
    )
    return [
        IncludeLaunchDescription(
            launch_file, launch_arguments={'namespace': LaunchConfiguration(argument)}.items()
        )
    ]
