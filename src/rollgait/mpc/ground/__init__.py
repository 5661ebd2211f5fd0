"""The ground as the controller sees it: looked up around the robot, quick enough for every step."""
