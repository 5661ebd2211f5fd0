"""Ground that is not level: what is under each foot along the horizon, looked up about the last solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import MODEL_SIZE, FootGround
from rollgait.dynamics.step import POINTS
from rollgait.mpc.clock import GaitClock, TimedSwing
from rollgait.mpc.ground.around import GroundAround
from rollgait.mpc.ground.landings import Landing, Landings
from rollgait.mpc.ground.raster import FRICTION, HEIGHT, ROLL_ROOM, SLOPE, STEP_ROOM
from rollgait.ocp.lift import minimum_jerk
from rollgait.robot.robot import Robot
from rollgait.terrain.references import TILT_SHARE
from rollgait.terrain.terrain import Terrain, normal_of

Array = NDArray[np.float64]

FEET: Final = 4
KEPT_OVER: Final = 0.02
"""A foot in the middle of its swing stays so far above the surface under it, m, whatever its profile says."""
SLOPE_MAX: Final = 0.45
"""Steepest slope of a contact that forces reckon with: steeper ones are edges that a wheel passes at once."""
LANDING_SHARE: Final = 0.25
"""In the last part of a swing, this share of it, the foot is drawn to where it may be set down."""
AFTER_LANDING: Final = 2
"""For so many intervals after it lands it is drawn to the foothold that was chosen."""
NEAR_EDGE: Final = 0.3
"""Feet farther from edges need not be kept off, m."""
CLEAR_WAY: Final = 0.3
"""Where the distance to an edge grows by less per metre there is another edge on the other side."""


@dataclass(frozen=True, eq=False)
class AlongHorizon:
    """The ground under the feet of one solve; N intervals.

    Attributes:
        model: of each foot in each interval and at the end, (N + 1, 4, 8).
        slope: of the contact, (N + 1, 4, 2); 0 where a foot does not stand.
        foot_height: above the model at the nodes, (N + 1, 4), m.
        lift_rate: how fast feet rise over the model at the points of the step, (8, N), m/s.
        normal, offset, counts: normal · p ≥ offset keeps feet off edges where it counts, (N + 1, 4, 2),
            (N + 1, 4) and (N + 1, 4).
        friction: least μ under the feet, (N,).
        base: mean ground under the feet, pitch and roll wanted, (3, N + 1).
    """

    model: Array
    slope: Array
    foot_height: Array
    lift_rate: Array
    normal: Array
    offset: Array
    counts: Array
    friction: Array
    base: Array


class TerrainGround:
    """The ground as the controller sees it.

    Args:
        terrain: the ground.
        robot: whose wheels.
    """

    def __init__(self, terrain: Terrain, robot: Robot) -> None:
        self.around = GroundAround(terrain, robot)
        self.landings = Landings(self.around)

    @property
    def radius(self) -> Array:
        """Of the wheels, (4,), m."""
        return self.around.radius

    def begin(self, xy: Array) -> None:
        """A robot begins anew, its feet at places (4, 2), m."""
        self.around.begin(xy.mean(axis=0))
        self.landings.begin(np.column_stack([xy, self.around.look(xy[None])[0, :, HEIGHT]]))

    # -- of one moment -----------------------------------------------------------------------------------

    def foot_heights(self, clock: GaitClock, times: Array, xy: Array) -> tuple[Array, Array]:
        surface = self.around.look(np.broadcast_to(xy, (times.size, FEET, 2)))[..., HEIGHT]
        z, rate = surface.copy(), np.zeros_like(surface)
        for swing in clock.swings(float(times.min()), float(times.max()) + 1e-9):
            landing = self.landings.of(swing)
            if landing is None:
                continue  # of the past or far ahead
            inside = (times > swing.lift_off) & (times < swing.touch_down)
            own, own_rate = landing.profile(swing, times[inside])
            half = 0.5 * (swing.touch_down - swing.lift_off)
            nearer = np.minimum(times[inside] - swing.lift_off, swing.touch_down - times[inside]) / half
            least = surface[inside, swing.leg] - swing.sunk + KEPT_OVER * minimum_jerk(nearer)[0]
            z[inside, swing.leg], rate[inside, swing.leg] = np.maximum(own, least), own_rate
        return z, rate

    def under(self, clock: GaitClock, time: float, xy: Array, z: Array) -> Sequence[FootGround] | None:
        contact, seen = clock.contact(time), self.around.look(xy[None])[0]
        model = np.zeros((FEET, MODEL_SIZE))
        model[:, :2], model[:, 2] = xy, np.where(contact, seen[:, HEIGHT], z)
        model[contact, 3:5] = seen[contact, SLOPE]
        slope = _bounded(model[:, 3:5])
        numbers = zip(model.tolist(), slope.tolist(), (contact * self.radius).tolist(), strict=True)
        return [FootGround(*of_foot) for of_foot in numbers]

    def normals(self, contact: NDArray[np.bool_], xy: Array) -> Array:
        slope = _bounded(self.around.look(xy[None])[0][:, SLOPE])
        return normal_of(np.where(contact[:, None], slope, 0.0))

    def touch(self, contact: NDArray[np.bool_], xy: Array, heading: Array) -> tuple[Array, Array]:
        slope = np.where(contact[:, None], self.around.look(xy[None])[0][:, SLOPE], 0.0)
        offset = self.radius[:, None] * (np.array([0.0, 0.0, 1.0]) - normal_of(_bounded(slope)))
        climb = (slope * np.column_stack([np.cos(heading), np.sin(heading)])).sum(axis=1)
        return offset, np.hypot(1.0, climb)

    def tilt(self, xy: Array, yaw: float) -> tuple[float, float]:
        feet = np.column_stack([xy, self.around.look(xy[None])[0, :, HEIGHT]])
        _, pitch, roll = base_along(feet[None], np.array([yaw]))[:, 0].tolist()
        return (pitch, roll)

    # -- of the horizon ----------------------------------------------------------------------------------

    def along(
        self,
        clock: GaitClock,
        time: float,
        interval: float,
        xy: Array,
        wanted: Array,
        stands: NDArray[np.bool_],
        yaw: Array,
    ) -> AlongHorizon:
        """The ground about a motion of the feet.

        Args:
            clock: which foot is in the air when.
            time: of the first node, s.
            interval: between nodes, s.
            xy: places of the feet at the nodes, (N + 1, 4, 2), m.
            wanted: nominal places, as `xy`.
            stands: which foot stands in some part of each interval, (4, N).
            yaw: wanted of the base at the nodes, (N + 1,), rad.
        """
        count = xy.shape[0] - 1
        times = time + interval * np.arange(count + 1)
        self.around.follow(xy[0].mean(axis=0))
        swings = self.landings.update(clock, time, interval, xy, wanted)
        ref = np.concatenate([0.5 * (xy[:-1] + xy[1:]), xy[-1:]])
        seen = self.around.look(np.concatenate([xy, ref]))
        node, middle = seen[: count + 1], seen[count + 1 :]
        z, under = node[..., HEIGHT].copy(), node[..., HEIGHT].copy()
        for swing, landing in swings:
            inside, passed = _passed(swing, times)
            z[inside, swing.leg] = landing.profile(swing, times[inside])[0]
            # feet in the air count on their way, lest the base jump with them
            rise = landing.end - landing.begin[2]
            under[inside, swing.leg] = landing.begin[2] + passed[inside] * rise
        in_air = np.vstack([~stands.T, ~clock.contact(float(times[-1]))[None]])
        model = np.zeros((count + 1, FEET, MODEL_SIZE))
        model[..., :2] = ref
        model[..., 2] = np.where(in_air, z, middle[..., HEIGHT])
        model[..., 3:5] = np.where(in_air[..., None], 0.0, middle[..., SLOPE])
        above = z - model[..., 2] - (model[..., 3:5] * (xy - ref)).sum(axis=-1)
        above[z == node[..., HEIGHT]] = 0.0  # a foot that stands is on its model, which bends less than it
        kind = STEP_ROOM if clock.gait.swing > 0.0 else ROLL_ROOM
        normal, offset, counts = self._keep_off(xy, node[..., kind], kind, swings, times, interval)
        self.landings.stand(clock.contact(time), np.column_stack([xy[0], node[0, :, HEIGHT]]))
        return AlongHorizon(
            model=model,
            slope=_bounded(model[..., 3:5]),
            foot_height=above,
            lift_rate=_lift_rates(swings, times, interval),
            normal=normal,
            offset=offset,
            counts=counts,
            friction=np.where(in_air[:-1], np.inf, middle[:-1, :, FRICTION]).min(axis=1),
            base=base_along(np.concatenate([xy, under[..., None]], axis=-1), yaw),
        )

    def _keep_off(
        self,
        xy: Array,
        room: Array,
        kind: int,
        swings: Sequence[tuple[TimedSwing, Landing]],
        times: Array,
        interval: float,
    ) -> tuple[Array, Array, Array]:
        """Half-planes normal · p ≥ offset that keep feet in what is allowed, about their places."""
        normal, offset = np.zeros_like(xy), np.zeros(room.shape)
        counts = (room < NEAR_EDGE).astype(float)
        for swing, _ in swings:
            inside, passed = _passed(swing, times)
            counts[inside & (passed < 1.0 - LANDING_SHARE), swing.leg] = 0.0
        for leg in np.flatnonzero(counts.any(axis=0)):
            near = counts[:, leg] > 0.0
            place = xy[near, leg]
            way = self.around.of(int(leg)).away(place, kind)
            growth = np.linalg.norm(way, axis=-1)
            clear = growth > CLEAR_WAY
            unit = way / np.maximum(growth, CLEAR_WAY)[:, None]
            normal[near, leg] = unit * clear[:, None]
            offset[near, leg] = np.where(clear, (unit * place).sum(axis=-1) - room[near, leg], 0.0)
        for swing, landing in swings:
            if landing.chosen is None:
                continue
            _, passed = _passed(swing, times)
            until = swing.touch_down + AFTER_LANDING * interval
            drawn = (passed >= 1.0 - LANDING_SHARE) & (times < until)
            normal[drawn, swing.leg], counts[drawn, swing.leg] = landing.side, 1.0
            offset[drawn, swing.leg] = float(landing.side @ landing.chosen)
        return normal, offset, counts


def base_along(feet: Array, yaw: Array, share: float = TILT_SHARE) -> Array:
    """`base_reference` of many moments at once: mean ground, pitch and roll, (3, n).

    Args:
        feet: lowest points of the rims, (n, 4, 3), m.
        yaw: of the base, (n,), rad.
        share: of the slope that the base takes.
    """
    d = feet - feet.mean(axis=1, keepdims=True)
    xx, xy, yy = ((d[..., a] * d[..., b]).sum(axis=1) for a, b in ((0, 0), (0, 1), (1, 1)))
    xz, yz = ((d[..., a] * d[..., 2]).sum(axis=1) for a in range(2))
    determinant = np.maximum(xx * yy - xy**2, 1e-9)
    gx, gy = (yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant
    c, s = np.cos(yaw), np.sin(yaw)
    forward, left = c * gx + s * gy, c * gy - s * gx
    return np.stack([feet[..., 2].mean(axis=1), -share * np.arctan(forward), share * np.arctan(left)])


def _passed(swing: TimedSwing, times: Array) -> tuple[NDArray[np.bool_], Array]:
    """Which times lie in a swing, and the share of it that is over then."""
    passed = (times - swing.lift_off) / (swing.touch_down - swing.lift_off)
    return (passed > 0.0) & (passed < 1.0), passed


def _lift_rates(swings: Sequence[tuple[TimedSwing, Landing]], times: Array, interval: float) -> Array:
    """How fast feet rise at the points of the step, (8, N), m/s."""
    points = times[:-1, None] + interval * np.array(POINTS)
    rate = np.zeros((*points.shape, FEET))
    for swing, landing in swings:
        inside, _ = _passed(swing, points)
        rate[inside, swing.leg] = landing.profile(swing, points[inside])[1]
    return np.moveaxis(rate, 0, -1).swapaxes(0, 1).reshape(-1, points.shape[0])


def _bounded(slope: Array) -> Array:
    """Slopes (…, 2), the steep ones less so."""
    size = np.linalg.norm(slope, axis=-1, keepdims=True)
    return np.asarray(slope * np.minimum(1.0, SLOPE_MAX / np.maximum(size, 1e-9)))
