"""The run file: its types, its writer and its reader. One `.mcap`, readable by ROS 2 tools."""
