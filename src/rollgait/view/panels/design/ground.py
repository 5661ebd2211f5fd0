"""The ground: parts that are added and dragged, friction, and a map of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import viser

from rollgait.scenario.scenario import Scenario
from rollgait.terrain.parts import PART_KINDS
from rollgait.view.design.handles import Selection
from rollgait.view.design.parts import pose_of, with_copy_of_part, with_part, without_part
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import Fields, by_a_person, choose, put
from rollgait.view.panels.design.places import POSE, REMOVE

COPY: Final = "copy"
ENDLESS: Final = "0: without end"
SIZES: Final[dict[str, str]] = {
    "steps": "",
    "rise": "",
    "slope_deg": "",
    "tread": "",
    "height": "",
    "length": "",
    "depth": "",
    "width": ENDLESS,
    "landing": ENDLESS,
    "z": "Of its foot over the ground",
    "friction": "0: that of the ground",
}
"""What is said of a part beside its place, and of each key what else there is to say."""
LABELS: Final = {"steps": "steps", "slope_deg": "slope (degrees)", "friction": "friction of it"}
STEP: Final = 0.01
"""Of sizes, m."""
SCALE_OF_PNG: Final = 0.001
"""At first a grey value is a millimetre, m."""
RESOLUTION: Final = 0.05
"""Of a map at first, m."""
MAPS: Final = ".npy,.png,.tif,.tiff,.mcap,.db3"


class GroundPanel:
    """Parts, friction and a map.

    Args:
        gui: of the page.
        actions: what they do to the draft.
    """

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        self._gui, self._actions = gui, actions
        self._number = 0
        self._general = Fields(actions.change)
        with gui.add_folder("ground", expand_by_default=False) as self._folder:
            self.add = gui.add_button_group("add a part", PART_KINDS, hint="Comes before the robot; drag it")
            self.which: Any = gui.add_dropdown("part", ("none",), visible=False)
            self.place: Any = gui.add_vector3("its place", (0.0, 0.0, 0.0), step=STEP, hint=POSE)
            self._sizes = gui.add_folder("its size", visible=False)
            self._buttons = gui.add_button_group("this part", (COPY, REMOVE), visible=False)
            friction = gui.add_number("friction", 0.5, min=0.01, max=2.0, step=0.05)
            self._general.key(friction, "ground.friction")
            with gui.add_folder("a map of your own", expand_by_default=False):
                self._build_map(gui)
        self._fields = Fields(actions.change)
        self.place.visible = False
        self.add.on_click(lambda event: self._add(event.target.value))
        self.which.on_update(by_a_person(lambda _: self._choose()))
        self.place.on_update(by_a_person(lambda _: self._moved()))
        self._buttons.on_click(lambda event: self._copy_or_remove(event.target.value))

    def _build_map(self, gui: viser.GuiApi) -> None:
        resolution = gui.add_number(
            "cell (m)", RESOLUTION, min=0.001, max=10.0, step=0.001, hint="Of .npy and .png; others say it"
        )
        scale = gui.add_number(
            "scale", SCALE_OF_PNG, min=1e-6, max=1e3, step=1e-6, hint="Metres of a grey value, of .png"
        )
        origin = gui.add_vector2("first value at", (-2.0, -2.0), step=STEP, hint="x, y (m), of .npy and .png")
        upload = gui.add_upload_button(
            "Upload a map", icon=viser.Icon.MAP, mime_type=MAPS, color="gray", hint="Heights: " + MAPS
        )
        self._no_map = gui.add_button("Take the map away", color="gray", visible=False)
        self._no_map.on_click(lambda _: self._actions.change({"ground.map": None}, ""))

        def take(event: Any) -> None:
            self._actions.take_map(
                event.target.value,
                {
                    "resolution": float(resolution.value),
                    "scale": float(scale.value),
                    "origin": [float(part) for part in origin.value],
                },
            )

        upload.on_upload(take)

    def show(self, scenario: Scenario, selected: Selection) -> None:
        """Shows the ground, and of its parts the one with the handle."""
        self._general.show(scenario)
        parts = scenario.ground.parts
        if selected.kind == "part":
            self._number = selected.number
        self._number = max(0, min(self._number, len(parts) - 1))
        names = tuple(f"{k + 1}  {part.kind}" for k, part in enumerate(parts)) or ("none",)
        choose(self.which, names, names[self._number])
        for handle in (self.which, self.place, self._sizes, self._buttons):
            handle.visible = bool(parts)
        self._no_map.visible = scenario.ground.map is not None
        if not parts:
            return
        part = parts[self._number]
        put(self.place, tuple(pose_of(part).values()))
        sizes = _names(part)
        self._fields.rebuild((self._number, part.kind, sizes), self._sizes, lambda: self._build_sizes(sizes))
        self._fields.show(scenario)

    def drag(self, pose: Mapping[str, float]) -> None:
        """Shows where the handle is while it is dragged."""
        put(self.place, tuple(pose.values()))

    def _build_sizes(self, names: tuple[str, ...]) -> None:
        for name in names:
            self._size(self._number, name)

    def _size(self, number: int, name: str) -> None:
        """A box of one size of a part; of what may be none 0 means that."""
        optional = name in ("width", "landing", "friction") or SIZES[name] == ENDLESS
        key = f"ground.parts.{number}.{name}"
        whole = name == "steps"
        box: Any = self._gui.add_number(
            LABELS.get(name, f"{name} (m)"),
            1 if whole else 0.0,
            min=1 if whole else None,
            step=1 if whole else STEP,
            hint=SIZES[name] or None,
        )

        def read(scenario: Scenario) -> Any:
            parts = scenario.ground.parts
            value = getattr(parts[number], name, None) if number < len(parts) else None
            return 0.0 if value is None else value

        def write(value: Any) -> dict[str, Any]:
            absent = value == 0 and (optional or self._may_be_none(number, name))
            return {key: None if absent else int(value) if whole else float(value)}

        self._fields.bind(box, read, write, key)

    def _may_be_none(self, number: int, name: str) -> bool:
        parts = self._actions.scenario.ground.parts
        return number < len(parts) and not type(parts[number]).model_fields[name].is_required()

    def _choose(self) -> None:
        self._number = int(self.which.value.split()[0]) - 1
        self._actions.select(Selection("part", self._number))

    def _moved(self) -> None:
        what = Selection("part", self._number)
        values = dict(zip(("x", "y", "yaw_deg"), map(float, self.place.value), strict=True))
        self._actions.change(what.values(values), what.stroke)
        self._actions.select(what)

    def _add(self, kind: str) -> None:
        scenario = self._actions.scenario
        self._actions.change(with_part(scenario, kind), "")
        self._actions.select(Selection("part", len(scenario.ground.parts)))

    def _copy_or_remove(self, button: str) -> None:
        scenario = self._actions.scenario
        count = len(scenario.ground.parts)
        if self._number >= count:
            return
        if button == COPY:
            self._actions.change(with_copy_of_part(scenario, self._number), "")
            self._actions.select(Selection("part", count))
        else:
            self._actions.change(without_part(scenario, self._number), "")
            self._actions.select(Selection("part", max(self._number - 1, 0)) if count > 1 else Selection())


def _names(part: Any) -> tuple[str, ...]:
    """Of which sizes a part has boxes: of rise and slope the one that it says."""
    names = [name for name in SIZES if name in type(part).model_fields]
    if part.kind == "ramp":
        names.remove("slope_deg" if part.slope_deg is None else "rise")
    return tuple(names)
