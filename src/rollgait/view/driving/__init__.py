"""Driving a robot live: a page with a joystick, a control loop in its own process, and what goes between."""
