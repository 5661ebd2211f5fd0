"""Receding-horizon control: stepping, rolling and steering in real time."""
