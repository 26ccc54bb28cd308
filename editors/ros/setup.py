"""Install the launch file and the command where ROS 2 looks for them. Improv itself comes from pip."""

from setuptools import setup

setup(
    name="improv",
    version="0.1.0",
    packages=[],
    py_modules=[],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/improv"]),
        ("share/improv", ["package.xml"]),
        ("share/improv/launch", ["launch/dance.launch.py"]),
        ("lib/improv", ["scripts/improv"]),
    ],
)
