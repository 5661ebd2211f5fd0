"""No test is about time, and none about luck: a machine that is busy, or another day, decides nothing.

Properties are tried on the same examples in every run. To hunt with others:
`python -m pytest -m hypothesis --hypothesis-profile=hunt --hypothesis-seed=SEED tests/…`.
"""

import signal

from hypothesis import settings

settings.register_profile("hunt", deadline=None, derandomize=False)
settings.register_profile("same", deadline=None, derandomize=True)
settings.load_profile("same")

if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # begun in the background of a shell
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what tests start can be interrupted
