"""From the continuous problem to a nonlinear program, and back."""

TRANSCRIPTION_NAMES = ("collocation",)
"""Names under which a transcription can be asked for."""
