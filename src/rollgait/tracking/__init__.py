"""From a plan to joints: hierarchical inverse kinematics on the whole body.

Needs the extra `whole-body`; importing this package does not load it, `track` does.
"""

from rollgait.tracking.entry import track
from rollgait.tracking.joints import JointTrajectory
from rollgait.tracking.report import TrackingReport, TrackingRow

__all__ = ["JointTrajectory", "TrackingReport", "TrackingRow", "track"]
