"""Ground that is not level: what is under each foot along the horizon, looked up about the last solution."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import FootGround
from rollgait.dynamics.step import POINTS
from rollgait.mpc.clock import GaitClock, TimedSwing
from rollgait.mpc.ground.raster import (
    FRICTION,
    HEIGHT,
    ROLL_ROOM,
    SLOPE_X,
    SLOPE_Y,
    STEP_ROOM,
    Raster,
)
from rollgait.ocp.lift import minimum_jerk
from rollgait.robot.robot import Robot
from rollgait.terrain.references import TILT_SHARE
from rollgait.terrain.regions import Regions, regions_of
from rollgait.terrain.terrain import Terrain, normal_of

Array = NDArray[np.float64]

FEET: Final = 4
RENEWED_AT: Final = 1.8
"""A raster is renewed when the robot is so near to its border, m."""
KEPT_OVER: Final = 0.02
"""A foot in the middle of its swing stays so far above the surface under it, m, whatever its profile says."""
STICKY: Final = 0.06
"""A foothold that was chosen stays unless another one is nearer to what is wanted by so much, m."""
SETTLED: Final = 0.5
"""From this share of a swing on, its foothold stays whatever happens."""
SLOPE_MAX: Final = 0.45
"""Steepest slope of a contact that the forces reckon with: steeper ones are edges that pass at once."""
NEAR_LANDING: Final = 0.25
"""In the last part of a swing, this share of it, the foot is drawn to where it may be set down."""


@dataclass
class Landing:
    """Where a swing ends.

    Attributes:
        lift_off: when it began, s: tells swings apart.
        begin: where the foot left the ground, (3,), m.
        place: where it is to land, (2,), m.
        chosen: a foothold in place of the nominal one, which is forbidden; None if it is not.
        top: highest surface on its way, m.
        end: height of the surface where it lands, m.
    """

    lift_off: float
    begin: Array
    place: Array
    chosen: Array | None = None
    top: float = 0.0
    end: float = 0.0


@dataclass
class AlongHorizon:
    """The ground under the feet of one solve; N intervals.

    Attributes:
        model: of each foot in each interval and at the end, (4, N + 1, 8).
        slope: of the contact, (4, N + 1, 2); 0 where a foot does not stand.
        foot_height: above the model at the nodes, (N + 1, 4), m.
        lift_rate: how fast feet rise over the model at the points of the step, (8, N), m/s.
        normal, offset, counts: normal · p ≥ offset keeps feet off edges, (N + 1, 4, 2) and (N + 1, 4) each.
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


@dataclass
class TerrainGround:
    """The ground as the controller sees it.

    Args:
        terrain: the ground.
        robot: whose wheels.
    """

    terrain: Terrain
    robot: Robot
    landings: dict[int, Landing] = field(default_factory=dict)

    def __post_init__(self) -> None:
        radii = [leg.wheel_radius or 0.0 for leg in self.robot.leg_list]
        self.radius: Array = np.array(radii)
        kinds = sorted(set(radii))
        self._regions: list[Regions] = [regions_of(self.terrain, radius) for radius in kinds]
        self._kind = np.array([kinds.index(radius) for radius in radii])
        self._rasters: list[Raster] | None = None
        self._coming: list[Raster] | None = None
        self._worker: threading.Thread | None = None
        self._last_stand: Array = np.zeros((FEET, 3))

    # -- the raster --------------------------------------------------------------------------------------

    def begin(self, xy: Array) -> None:
        """Knows the ground about a robot whose feet stand at places (4, 2), and forgets its swings."""
        self.landings.clear()
        if self._rasters is None or self._rasters[0].room_to_border(xy.mean(axis=0)) < RENEWED_AT:
            self._rasters = self._made(xy.mean(axis=0))
        self._last_stand = np.column_stack([xy, self.look(xy[None])[0, :, HEIGHT]])

    def _made(self, centre: Array) -> list[Raster]:
        return [Raster.around(regions, centre) for regions in self._regions]

    def _renew(self, centre: Array) -> None:
        """Has a raster made about a place by another thread, where the present one ends soon."""
        assert self._rasters is not None
        if self._worker is not None:
            if self._worker.is_alive():
                return
            self._worker = None
            self._rasters = self._coming or self._rasters
        elif self._rasters[0].room_to_border(centre) < RENEWED_AT:
            self._worker = threading.Thread(target=self._make_coming, args=(centre.copy(),), daemon=True)
            self._worker.start()

    def _make_coming(self, centre: Array) -> None:
        self._coming = self._made(centre)

    def look(self, xy: Array) -> Array:
        """What is known under places (n, 4, 2) of the feet, (n, 4, 6); see `Raster.look`."""
        assert self._rasters is not None
        if len(self._rasters) == 1:
            return self._rasters[0].look(xy)
        result = np.empty((*xy.shape[:-1], 6))
        for kind, raster in enumerate(self._rasters):
            legs = self._kind == kind
            result[:, legs] = raster.look(xy[:, legs])
        return result

    def _raster(self, leg: int) -> Raster:
        assert self._rasters is not None
        return self._rasters[self._kind[leg]]

    # -- swings ------------------------------------------------------------------------------------------

    def _update_landings(
        self, clock: GaitClock, time: float, interval: float, xy: Array, wanted: Array
    ) -> dict[int, list[Landing]]:
        """Where the swings of the horizon begin and end, by leg in the order of time.

        Args:
            clock: which foot is in the air when.
            time: of the first node, s.
            interval: between nodes, s.
            xy: places of the feet at the nodes, (N + 1, 4, 2), m.
            wanted: nominal places, as `xy`.
        """
        last = xy.shape[0] - 1
        result: dict[int, list[Landing]] = {}
        for swing in sorted(clock.swings(time, time + last * interval), key=lambda one: one.lift_off):
            leg = swing.leg
            known = self.landings.get(leg)
            under_way = swing.lift_off <= time
            if known is None or abs(known.lift_off - swing.lift_off) > 1e-6:
                begin = self._last_stand[leg] if under_way else self._at(leg, xy, swing.lift_off, time, interval)
                known = Landing(swing.lift_off, begin.copy(), begin[:2].copy())
            if not under_way:
                known.begin = self._at(leg, xy, swing.lift_off, time, interval)
            self._choose(known, swing, time, interval, xy, wanted)
            if leg not in result:
                self.landings[leg] = known
            result.setdefault(leg, []).append(known)
        for leg in [leg for leg in self.landings if leg not in result]:
            del self.landings[leg]
        return result

    def _at(self, leg: int, xy: Array, when: float, time: float, interval: float) -> Array:
        """Where a foot is on the ground at a time of the horizon, (3,), m."""
        place = _between(xy[:, leg], (when - time) / interval)
        height = self._raster(leg).look(place)[HEIGHT]
        return np.array([*place, float(height)])

    def _choose(
        self, landing: Landing, swing: TimedSwing, time: float, interval: float, xy: Array, wanted: Array
    ) -> None:
        """Where a swing is to land: where the last solution has it, or the nearest place that is allowed."""
        leg, raster = swing.leg, self._raster(swing.leg)
        share = (swing.touch_down - time) / interval
        place = _between(xy[:, leg], share)
        passed = (time - swing.lift_off) / (swing.touch_down - swing.lift_off)
        nominal = _between(wanted[:, leg], share)
        if passed < SETTLED:
            if raster.look(nominal)[STEP_ROOM] >= 0.0:
                new = None
            else:
                new = raster.nearest_foothold(nominal)
            old = landing.chosen
            if new is None and old is not None and raster.look(nominal)[STEP_ROOM] < 0.5 * STICKY:
                new = old
            elif new is not None and old is not None:
                gain = np.linalg.norm(old - nominal) - np.linalg.norm(new - nominal)
                new = new if gain > STICKY else old
            landing.chosen = new
        landing.place = place if landing.chosen is None else landing.chosen
        way = landing.begin[:2] + np.linspace(0.0, 1.0, 9)[:, None] * (landing.place - landing.begin[:2])
        heights = raster.look(way)[:, HEIGHT]
        landing.top = float(max(heights.max(), landing.begin[2]))
        # the height where it comes down in fact, though it may still be drawn elsewhere
        landing.end = float(raster.look(place)[HEIGHT] if passed > SETTLED else heights[-1])

    @staticmethod
    def _profile(swing: TimedSwing, landing: Landing, times: Array) -> tuple[Array, Array]:
        """z and its rate in a swing at times in it."""
        half = 0.5 * (swing.touch_down - swing.lift_off)
        apex = max(landing.top, landing.end) + swing.clearance
        rise, fall = (times - swing.lift_off) / half, (swing.touch_down - times) / half
        rises = rise < fall
        value, slope = minimum_jerk(np.minimum(rise, fall))
        foot = np.where(rises, landing.begin[2], landing.end)
        z = foot + (apex - foot) * value
        return z, np.where(rises, 1.0, -1.0) * (apex - foot) * slope / half

    # -- of one moment -----------------------------------------------------------------------------------

    def foot_heights(self, clock: GaitClock, times: Array, xy: Array) -> tuple[Array, Array]:
        surface = self.look(np.broadcast_to(xy, (times.size, FEET, 2)))[..., HEIGHT]
        z, rate = surface.copy(), np.zeros_like(surface)
        for swing in clock.swings(float(times.min()), float(times.max()) + 1e-9):
            landing = self.landings.get(swing.leg)
            if landing is None or abs(landing.lift_off - swing.lift_off) > 1e-6:
                continue  # of the past or far ahead
            inside = (times > swing.lift_off) & (times < swing.touch_down)
            own, own_rate = self._profile(swing, landing, times[inside])
            half = 0.5 * (swing.touch_down - swing.lift_off)
            nearer = np.minimum(times[inside] - swing.lift_off, swing.touch_down - times[inside]) / half
            least = surface[inside, swing.leg] + KEPT_OVER * minimum_jerk(nearer)[0]
            z[inside, swing.leg], rate[inside, swing.leg] = np.maximum(own, least), own_rate
        return z, rate

    def under(self, clock: GaitClock, time: float, xy: Array, z: Array) -> Sequence[FootGround] | None:
        contact, seen = clock.contact(time), self.look(xy[None])[0]
        result = []
        for leg in range(FEET):
            slope = seen[leg, SLOPE_X : SLOPE_Y + 1].tolist() if contact[leg] else [0.0, 0.0]
            height = float(seen[leg, HEIGHT]) if contact[leg] else float(z[leg])
            model = [*xy[leg].tolist(), height, *slope, 0.0, 0.0, 0.0]
            bounded = _bounded(np.array(slope)).tolist()
            result.append(FootGround(model, bounded, float(self.radius[leg]) if contact[leg] else 0.0))
        return result

    def normals(self, contact: NDArray[np.bool_], xy: Array) -> Array:
        slope = _bounded(self.look(xy[None])[0][:, SLOPE_X : SLOPE_Y + 1])
        return normal_of(np.where(contact[:, None], slope, 0.0))

    # -- of the horizon ----------------------------------------------------------------------------------

    def along(
        self, clock: GaitClock, time: float, interval: float, xy: Array, wanted: Array, stands: Array, yaw: Array
    ) -> AlongHorizon:
        """The ground about a motion of the feet.

        Args:
            clock: which foot is in the air when.
            time: of the first node, s.
            interval: between nodes, s.
            xy: places of the feet at the nodes, (N + 1, 4, 2), m.
            wanted: nominal places, as `xy`.
            stands: which foot stands in some part of each interval, (4, N).
            yaw: of the base at the nodes, (N + 1,), rad.
        """
        count = xy.shape[0] - 1
        times = time + interval * np.arange(count + 1)
        self._renew(xy[0].mean(axis=0))
        swings = clock.swings(float(times[0]), float(times[-1]) + 1e-9)
        landings = self._update_landings(clock, time, interval, xy, wanted)
        middle = 0.5 * (xy[:-1] + xy[1:])
        seen = self.look(np.concatenate([xy, middle]))
        node, between = seen[: count + 1], np.concatenate([seen[count + 1 :], seen[count : count + 1]])
        ref = np.concatenate([middle, xy[-1:]])
        model = np.zeros((count + 1, FEET, 8))
        model[..., :2], model[..., 2] = ref, between[..., HEIGHT]
        model[..., 3:5] = between[..., SLOPE_X : SLOPE_Y + 1]
        z, under = node[..., HEIGHT].copy(), node[..., HEIGHT].copy()
        counts = np.ones((count + 1, FEET))
        points, rate = times[:-1, None] + interval * np.array(POINTS), np.zeros((count, len(POINTS), FEET))
        drawn: list[tuple[int, NDArray[np.bool_], Array]] = []
        number = dict.fromkeys(range(FEET), 0)
        for swing in sorted(swings, key=lambda one: one.lift_off):
            own = landings.get(swing.leg, [])
            if number[swing.leg] >= len(own):
                continue
            landing = own[number[swing.leg]]
            number[swing.leg] += 1
            leg = swing.leg
            inside = (times > swing.lift_off) & (times < swing.touch_down)
            passed = (times - swing.lift_off) / (swing.touch_down - swing.lift_off)
            z[inside, leg] = self._profile(swing, landing, times[inside])[0]
            flying = (points > swing.lift_off) & (points < swing.touch_down)
            rate[:, :, leg][flying] = self._profile(swing, landing, points[flying])[1]
            under[inside, leg] = landing.begin[2] + passed[inside] * (landing.end - landing.begin[2])
            counts[inside & (passed < 1.0 - NEAR_LANDING), leg] = 0.0
            if landing.chosen is not None:
                drawn.append((leg, (passed >= 1.0 - NEAR_LANDING) & (times < swing.touch_down + 2 * interval), landing.chosen))
        in_air = np.vstack([~(stands.T > 0.0), ~clock.contact(float(times[-1]))[None]])
        level = np.concatenate([z[:-1], z[-1:]])
        model[in_air, 2], model[in_air, 3:] = level[in_air], 0.0
        slope = np.where(in_air[..., None], 0.0, _bounded(between[..., SLOPE_X : SLOPE_Y + 1]))
        d = xy - ref
        above = z - model[..., 2] - (model[..., 3:5] * d).sum(axis=-1)
        in_contact = z == node[..., HEIGHT]
        above[in_contact] = 0.0  # on the model exactly: what bends between is the surface's own
        steps = clock.gait.swing > 0.0
        kind = STEP_ROOM if steps else ROLL_ROOM
        normal, offset = self._keep_off(xy, node[..., kind], kind, counts)
        for leg, when, chosen in drawn:
            nominal = wanted[when, leg]
            if not len(nominal):
                continue
            away = chosen - nominal
            size = np.linalg.norm(away, axis=-1, keepdims=True)
            unit = np.where(size > 1e-6, away / np.maximum(size, 1e-6), 0.0)
            normal[when, leg], offset[when, leg] = unit, (unit * chosen).sum(axis=-1)
            counts[when, leg] = 1.0
        base = base_along(np.concatenate([xy, under[..., None]], axis=-1), yaw)
        friction = np.where(in_air[:-1], np.inf, between[:-1, :, FRICTION]).min(axis=1)
        self._note_stands(clock.contact(time), xy[0], node[0, :, HEIGHT])
        return AlongHorizon(
            model=np.moveaxis(model, 1, 0),
            slope=np.moveaxis(slope, 1, 0),
            foot_height=above,
            lift_rate=np.moveaxis(rate, 0, -1).swapaxes(0, 1).reshape(-1, count),
            normal=normal,
            offset=offset,
            counts=counts,
            friction=friction,
            base=base,
        )

    def _note_stands(self, contact: NDArray[np.bool_], xy: Array, height: Array) -> None:
        self._last_stand[contact] = np.column_stack([xy, height])[contact]

    def _keep_off(self, xy: Array, room: Array, kind: int, counts: Array) -> tuple[Array, Array]:
        """Half-planes normal · p ≥ offset that keep feet in what is allowed, about their places."""
        normal, offset = np.zeros_like(xy), np.zeros(room.shape)
        near = room < 0.3
        counts[~near] = 0.0
        if not near.any():
            return normal, offset
        nodes, legs = np.nonzero(near)
        for leg in range(FEET):
            own = legs == leg
            if not own.any():
                continue
            where = nodes[own]
            slope = self._raster(leg).away(xy[where, leg], kind)
            size = np.linalg.norm(slope, axis=-1)
            unit = slope / np.maximum(size, 1e-6)[:, None]
            good = size > 0.3  # in the middle between two edges there is no way out to be told
            normal[where, leg] = np.where(good[:, None], unit, 0.0)
            offset[where, leg] = np.where(good, (unit * xy[where, leg]).sum(axis=-1) - room[where, leg], 0.0)
        return normal, offset


def base_along(feet: Array, yaw: Array, share: float = TILT_SHARE) -> Array:
    """Mean ground, pitch and roll wanted of the base over feet (n, 4, 3), (3, n): `base_reference` at once."""
    d = feet - feet.mean(axis=1, keepdims=True)
    xx, xy, yy = ((d[..., a] * d[..., b]).sum(axis=1) for a, b in ((0, 0), (0, 1), (1, 1)))
    xz, yz = ((d[..., a] * d[..., 2]).sum(axis=1) for a in range(2))
    determinant = np.maximum(xx * yy - xy**2, 1e-9)
    gx, gy = (yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant
    c, s = np.cos(yaw), np.sin(yaw)
    forward, left = c * gx + s * gy, c * gy - s * gx
    return np.stack([feet[..., 2].mean(axis=1), -share * np.arctan(forward), share * np.arctan(left)])


def _between(rows: Array, place: float) -> Array:
    """A row between two, counted in rows; the last beyond the end."""
    k = int(np.clip(np.floor(place), 0, len(rows) - 2))
    a = float(np.clip(place - k, 0.0, 1.0))
    return np.asarray((1.0 - a) * rows[k] + a * rows[k + 1])


def _bounded(slope: Array) -> Array:
    """Slopes (…, 2), the steep ones less so."""
    size = np.linalg.norm(slope, axis=-1, keepdims=True)
    return np.asarray(slope * np.minimum(1.0, SLOPE_MAX / np.maximum(size, 1e-9)))
