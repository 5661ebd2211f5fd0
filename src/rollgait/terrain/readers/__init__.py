"""Readers of maps: one module for each format, imported when such a file is read."""
