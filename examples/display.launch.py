# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Show the positioner's valve in RViz: ros2 launch display.launch.py."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

HERE = Path(__file__).resolve().parent
URDF = HERE.parent / 'urdf' / 'control_valve.urdf'


def generate_launch_description() -> LaunchDescription:
    """Start the positioner, what makes frames of its joint, and RViz."""
    return LaunchDescription([
        IncludeLaunchDescription(PathJoinSubstitution(
            [FindPackageShare('booster_ros'), 'launch', 'positioner.launch.py'])),
        Node(
            package='robot_state_publisher',
            executable='robot_state_publisher',
            parameters=[{'robot_description': URDF.read_text()}],
            remappings=[('joint_states', 'valve_position_stamped')],
        ),
        Node(package='rviz2', executable='rviz2', arguments=['-d', str(HERE / 'valve.rviz')]),
    ])
