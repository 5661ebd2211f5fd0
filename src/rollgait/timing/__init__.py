"""Timing as a variable: when feet lift off and touch down, and what a tenth of a second is worth."""
