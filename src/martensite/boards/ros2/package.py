"""`build_ros2_package`: a package for ROS 2 around the firmware of a scenario.

The hardware interface is the shape that `ros2_control` (Humble and later) wants; everything below it, `sma_board`, is
plain C++ on the C of the link and is tested without ROS. The package itself was not built: ROS 2 was not to be had.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from martensite.base.errors import InputError
from martensite.boards.firmware.boards import find_board
from martensite.boards.link.messages import print_header
from martensite.boards.session import read_project

TEMPLATES = ("sma_system.hpp", "sma_system.cpp")
PLAIN = ("sma_board.hpp", "sma_board.cpp")
NAME = re.compile(r"[a-z][a-z0-9_]*")


def build_ros2_package(project: Path, name: str) -> dict[str, str]:
    """Texts of a package by the path of their file.

    Args:
        project: a folder that `martensite export firmware` wrote.
        name: of the package: small letters, digits and underscores.

    Raises:
        DataError: it is no such folder.
        InputError: it is no name of a package.
    """
    if not NAME.fullmatch(name):
        raise InputError(
            f"`{name}` is no name of a ROS package: small letters, digits and underscores, a letter first."
        )
    firmware, home = read_project(project), files("martensite.boards")
    found = {f"src/{one}": (home / "ros2" / one).read_text("utf-8").replace("@PACKAGE@", name) for one in TEMPLATES}
    found |= {f"src/{one}": (home / "ros2" / one).read_text("utf-8") for one in PLAIN}
    found |= {f"src/{one}": (home / "c" / one).read_text("utf-8") for one in ("link.c", "link.h")}
    found["src/messages.h"] = print_header()
    found["src/firmware.hpp"] = print_firmware_header(firmware)
    found["package.xml"] = _PACKAGE.format(name=name)
    found["CMakeLists.txt"] = _CMAKE.replace("@PACKAGE@", name)
    found["plugins.xml"] = _PLUGIN.format(name=name)
    found["msg/SmaState.msg"] = print_message(firmware)
    found[f"urdf/{name}.ros2_control.xacro"] = print_description(firmware, name)
    found["README.md"] = _README.format(name=name)
    return found


def list_states(firmware: Mapping[str, Any]) -> list[str]:
    """Names of state interfaces: those of the telemetry."""
    return [row["name"].replace(".", "_") for row in firmware["telemetry"]]


def list_commands(firmware: Mapping[str, Any]) -> list[tuple[int, str, float]]:
    """Place, name and first value of the settings that a command interface gives: references and free signals."""
    rows = list(enumerate(firmware["settings"]))
    last = max(k for k, row in rows if row["name"].startswith(("offset ", "calibrated")))
    return [(k, row["name"].replace(".", "_"), row["value"]) for k, row in rows[last + 1 :]]


def print_firmware_header(firmware: Mapping[str, Any]) -> str:
    """`firmware.hpp`: what the interface must know of the board."""
    states, commands = list_states(firmware), list_commands(firmware)
    return "\n".join(
        [
            "/* Printed by martensite from firmware.json. */",
            "#pragma once",
            "#include <cstdint>",
            "namespace firmware {",
            f"constexpr std::uint32_t digest = {firmware['digest']:#x};",
            f"constexpr int baud = {find_board(firmware['board']).baud};",
            f"constexpr const char *states[] = {{{', '.join(map(_quote_text, states))}}};",
            f"constexpr const char *commands[] = {{{', '.join(_quote_text(name) for _, name, _ in commands)}}};",
            f"constexpr std::uint8_t places[] = {{{', '.join(str(place) for place, _, _ in commands)}}};",
            f"constexpr double first[] = {{{', '.join(repr(float(value)) for _, _, value in commands)}}};",
            "}  // namespace firmware",
            "",
        ]
    )


def print_message(firmware: Mapping[str, Any]) -> str:
    """`SmaState.msg`: a telemetry as a message, in SI."""
    rows = ["std_msgs/Header header", "uint8 flags", "uint8 alarm"]
    rows += [f"float64 {row['name'].replace('.', '_').lower()}  # {row['unit']}" for row in firmware["telemetry"]]
    return "\n".join([*rows, ""])


def print_description(firmware: Mapping[str, Any], name: str) -> str:
    """The `ros2_control` tag of a robot description."""
    states = "".join(f'      <state_interface name="{one}"/>\n' for one in list_states(firmware))
    commands = "".join(f'      <command_interface name="{one}"/>\n' for _, one, _ in list_commands(firmware))
    return (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
        f'  <xacro:macro name="{name}" params="port arm:=no">\n'
        f'    <ros2_control name="{name}" type="system">\n'
        f"      <hardware>\n        <plugin>{name}/SmaSystem</plugin>\n"
        '        <param name="port">${port}</param>\n        <param name="arm">${arm}</param>\n      </hardware>\n'
        f'      <gpio name="{name}">\n{commands}{states}      </gpio>\n'
        "    </ros2_control>\n  </xacro:macro>\n</robot>\n"
    )


def _quote_text(text: str) -> str:
    return f'"{text}"'


_PACKAGE = """<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.1.0</version>
  <description>A shape-memory-alloy actuator behind a board, for ros2_control; written by martensite.</description>
  <maintainer email="you@example.org">you</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>hardware_interface</depend>
  <depend>pluginlib</depend>
  <depend>rclcpp</depend>
  <depend>rclcpp_lifecycle</depend>
  <depend>std_msgs</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
_CMAKE = """cmake_minimum_required(VERSION 3.16)
project(@PACKAGE@ C CXX)
set(CMAKE_CXX_STANDARD 17)
find_package(ament_cmake REQUIRED)
find_package(hardware_interface REQUIRED)
find_package(pluginlib REQUIRED)
find_package(rclcpp REQUIRED)
find_package(rclcpp_lifecycle REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(std_msgs REQUIRED)
rosidl_generate_interfaces(${PROJECT_NAME} msg/SmaState.msg DEPENDENCIES std_msgs)
add_library(sma_system SHARED src/sma_system.cpp src/sma_board.cpp src/link.c)
target_include_directories(sma_system PRIVATE src)
ament_target_dependencies(sma_system hardware_interface pluginlib rclcpp rclcpp_lifecycle)
pluginlib_export_plugin_description_file(hardware_interface plugins.xml)
install(TARGETS sma_system DESTINATION lib)
install(DIRECTORY urdf DESTINATION share/${PROJECT_NAME})
ament_package()
"""
_PLUGIN = """<library path="sma_system">
  <class name="{name}/SmaSystem" type="{name}::SmaSystem" base_class_type="hardware_interface::SystemInterface">
    <description>A loop on a board, by its link.</description>
  </class>
</library>
"""
_README = """# {name}

A `ros2_control` hardware interface for a loop that runs on a board, written by `martensite export ros2`. State
interfaces are the numbers of its telemetry in SI, command interfaces its references.

This package was not built with ROS 2 by those who wrote it: what it stands on, `sma_board` and the link, was compiled
and run against a board without ROS; the interface has the shape of Humble and later.

    colcon build --packages-select {name}

Nothing is armed unless the hardware parameter `arm` is `ARM`. The board disarms when it hears nothing for 40 ms: run
the controller manager at 50 Hz or more.
"""
