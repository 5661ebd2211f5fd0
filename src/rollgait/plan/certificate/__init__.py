"""The certificate: a plan measured by code that shares nothing with the optimiser.

It uses NumPy, its own equations of motion and its own integration of them, and knows the plan only through
`plan.sample`.
"""

from rollgait.plan.certificate.judge import certify
from rollgait.plan.certificate.rows import Certificate, Row, Verdict

__all__ = ["Certificate", "Row", "Verdict", "certify"]
