"""Starts the node, and RViz if asked to.

    ros2 launch query/ros/launch/grasp.launch.py index:=grasp.idx image:=/camera/image_raw rviz:=true

`program` is the node's file, where it is not among the programs of $PATH.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

RVIZ = Path(__file__).resolve().parent.parent / "rviz" / "grasp.rviz"

#: What the node is told, with its defaults; the node's own help says more.
PARAMETERS = {
    "index": ("", "the index; empty: the one that the node finds by itself"),
    "image_transport": ("raw", "raw or compressed"),
    "hand": ("auto", "which hand the pictures show: auto, left or right"),
    "sequence": ("false", "answer each picture by all pictures so far"),
    "depth": ("1.0", "how far away the hand is said to be, in metres"),
    "rectified": ("auto", "whether pictures are rectified: auto (by the topic's name), true or false"),
    "robot": ("", "the robot hand whose grasps are published; empty: none"),
    "object": ("", "the file that describes the object"),
    "camera": ("", "the file that describes the camera"),
    "arm": ("", "the arm, if it limits the grasps"),
    "world_frame": ("world", "what the world is called among frames"),
}


def generate_launch_description():
    arguments = [
        DeclareLaunchArgument("program", default_value="grasp-ros", description="the node's program"),
        DeclareLaunchArgument("namespace", default_value="", description="the node's namespace"),
        DeclareLaunchArgument("image", default_value="/camera/image_raw", description="the pictures' topic"),
        DeclareLaunchArgument("rviz", default_value="false", description="start RViz as well"),
    ]
    arguments += [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in PARAMETERS.items()
    ]
    node = Node(
        executable=LaunchConfiguration("program"),
        name="grasp",
        namespace=LaunchConfiguration("namespace"),
        parameters=[{name: LaunchConfiguration(name) for name in PARAMETERS}],
        remappings=[("image", LaunchConfiguration("image"))],
        output="screen",
    )
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(RVIZ)],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )
    return LaunchDescription([*arguments, node, rviz])
