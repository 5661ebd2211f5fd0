"""By how much a plan may miss what it promises: every number with its unit and its reason."""

# -- the motion obeys the physics (per interval)
DEFECT_POSITION = 1e-4
"""m; a tenth of what the joints can place."""
DEFECT_ANGLE = 1e-3
"""rad; 0.06°, below what an IMU resolves."""
DEFECT_VELOCITY = 1e-3
"""m/s; a thousandth of the usual top speed."""
DEFECT_ANGULAR_VELOCITY = 1e-2
"""rad/s; the tolerated angle within the usual interval of 0.1 s."""

# -- feet
SLIP = 1e-3
"""m/s; far below what a rolling rubber wheel creeps."""
SKID_FRICTION = 0.05
"""Of sliding friction, which nobody knows so well; in an interval the wheel turns, its force does not."""
HEIGHT = 5e-4
"""m; less than a tyre yields under the load."""
KINK = 5e-3
"""m; so far from its place the ground may bend in a plan, which takes it as smooth. Times the change of slope
it is what wheels may be over or in the ground beside `HEIGHT`: 1.3 mm at 15°, 1.8 mm at 20°."""
PLACE = 0.05
"""m; so near to a kink nobody knows on which side of it a wheel stands: a robot misses its footholds by 3 cm,
and maps are as coarse."""
SLOPE = 0.02
"""Of the ground, 1°: 2 mm in 10 cm, which no map tells."""
EDGE = 0.029
"""m; what a robot misses its footholds by, less the tolerated length: so far from edges feet stand."""
KNOWN = 0.025
"""m; so far around their contacts feet know the ground: `EDGE`, less what lies between two probes."""
CONTACT = 0.01
"""m; of the contacts that a plan states, a tenth of a usual radius of wheels: constant in an interval,
in which a wheel may roll over a bend. (What that does to the motion is judged apart, as a defect.)"""
SWING_DEPTH = 2e-3
"""m; of rims in swing: where they leave the ground and come back to it a kink may be misplaced."""
STANDS_OUT = 0.01
"""m; what stands out of the ground between two footholds by more than this must be gone over."""
BODY = 0.01
"""m; of trunk and hips above the ground: what spheres are wrong by as legs move."""
CLEARANCE = 1e-3
"""m; 1 % of the usual clearance."""
FORCE = 0.1
"""N; a ten-thousandth of the weight, the accuracy of a well converged solver on scaled forces."""

# -- limits (kept exactly at the points where the solver enforces them, overshot a little between)
LENGTH_MARGIN = 1e-3
"""m; of box and reach."""
ANGLE_MARGIN = 1e-2
"""rad; of steering and joints: 0.6°."""
RATE_MARGIN = 2e-3
"""rad/s; a thousandth of the usual limit of 2 rad/s."""
SPEED_MARGIN = 1e-3
"""m/s; a thousandth of the usual limit of 1 m/s."""
ACCELERATION_MARGIN = 1e-2
"""m/s²; the tolerated speed within the usual interval of 0.1 s."""

# -- time
DURATION = 1e-6
"""s; nobody times a motion to a microsecond, and sums of intervals are a thousand times as exact."""

# -- the robot is the one that was asked for, and carries what it should
FIGURE = 1e-9
"""SI units, or share of a figure: the last digits of a sum differ from one computer to another."""
LOAD_MASS = 1e-6
"""kg; both sums are exact but for round-off."""
LOAD_INERTIA = 1e-6
"""Share of the trace; likewise."""

# -- both ends
START_POSITION = 1e-4
"""m; a hard equality of the problem."""
BEYOND = 0.05
"""m; so far beyond its limits a start in motion may be, as measured robots are."""
BEYOND_ANGLE = 0.1
"""rad; likewise."""
BEYOND_ROUNDING = 1e-6
"""m and rad; by so much more the start is allowed to be beyond a limit: what stands still does so but for
rounding."""
GRACE = 0.5
"""s; within that time it is back, the limit moving evenly from where the start is."""
END_POSITION = 1e-3
"""m; of the final stance."""
END_ANGLE = 1e-3
"""rad; of the start, and of level at the end."""
END_SPEED = 1e-3
"""m/s; what counts as rest."""
END_RATE = 1e-3
"""rad/s; what counts as rest."""
GOAL_DISTANCE = 0.01
"""m; the goal is a cost, not a constraint: 1 cm is the promise."""
GOAL_DISTANCE_LEGGED = 0.02
"""m; for feet that cannot roll, whose stride the boxes limit."""
GOAL_YAW = 1.0
"""deg."""

LARGEST = 1e9
"""SI units; a larger number is as good as none: it would only overflow."""
LIFT_OF_HEIGHT = 0.24
"""How far a foot may be lifted beyond its nominal place on ground that is not flat, in heights of the CoM."""
