# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Drive one positioner as a joint of ros2_control.

Needs the packages controller_manager, forward_command_controller, joint_state_broadcaster,
joint_state_topic_hardware_interface and robot_state_publisher.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Start the positioner, its description, the controller manager and two controllers."""
    share = FindPackageShare('booster_ros')
    urdf = Command(['cat ', PathJoinSubstitution([share, 'urdf', 'control_valve.urdf'])])
    use_sim_time = {
        'use_sim_time': ParameterValue(LaunchConfiguration('use_sim_time'), value_type=bool)
    }
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'params_file',
                default_value=PathJoinSubstitution([share, 'config', 'closed_loop.yaml']),
                description='ROS 2 parameter file of the positioner; its controller must be on',
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
                # not among `parameters`: a file that is not there would be passed over
                ros_arguments=[
                    '--params-file', LaunchConfiguration('params_file'),
                    '--log-level', LaunchConfiguration('log_level'),
                ],
                parameters=[use_sim_time],
                # joint_states itself is what the broadcaster publishes
                remappings=[('valve_position_stamped', 'valve_joint_states')],
                output='screen',
            ),
            Node(
                package='robot_state_publisher',
                executable='robot_state_publisher',
                parameters=[{'robot_description': ParameterValue(urdf, value_type=str)},
                            use_sim_time],
            ),
            Node(
                package='controller_manager',
                executable='ros2_control_node',
                parameters=[PathJoinSubstitution([share, 'config', 'ros2_controllers.yaml']),
                            use_sim_time],
                output='screen',
            ),
            Node(
                package='controller_manager',
                executable='spawner',
                arguments=['joint_state_broadcaster', 'position_command'],
            ),
        ]
    )
