"""`ros2 launch improv dance.launch.py file:=/path/to/dance.improv`: play a program, and again after each save."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description() -> LaunchDescription:
    """Return the node that plays, and its arguments, for `ros2 launch`."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("file", description="the program, with its whole path"),
            DeclareLaunchArgument("backend", default_value="ros", description="ros, both, or sim"),
            DeclareLaunchArgument("node", default_value="improv", description="the name of the node"),
            DeclareLaunchArgument("namespace", default_value="", description="the node's own namespace"),
            DeclareLaunchArgument("speed", default_value="1.0", description="times the tempo, from 0.1 to 4"),
            Node(
                package="improv",
                executable="improv",
                name=LaunchConfiguration("node"),
                namespace=LaunchConfiguration("namespace"),
                arguments=[
                    "watch",
                    LaunchConfiguration("file"),
                    "--backend",
                    LaunchConfiguration("backend"),
                    "--no-browser",
                ],
                parameters=[{"speed": ParameterValue(LaunchConfiguration("speed"), value_type=float)}],
                output="screen",
                emulate_tty=True,
            ),
        ]
    )
