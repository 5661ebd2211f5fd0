"""Why a scenario cannot be solved, and which single change would make it solvable."""

from rollgait.diagnosis.report import Diagnosis, Reason, Suggestion

__all__ = ["Diagnosis", "Reason", "Suggestion"]
