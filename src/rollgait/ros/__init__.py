"""What we say in ROS 2: topics, frames and messages as plain data, for writers of files and for live bridges.

Nothing here knows of files or networks. Only `cdr.py` needs a library, the extra `mcap`, and when it is used.
"""
