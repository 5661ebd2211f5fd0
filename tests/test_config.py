"""Laws of the input: it survives the round trip through YAML; junk in it is an InputError, nothing else."""

import contextlib
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from rollgait.config import dump_yaml, parse_setting, parse_value, parse_yaml, set_key
from rollgait.errors import FileError, InputError
from rollgait.robot import LEG_NAMES, find_robot, robot_names
from rollgait.scenario import Goal, Scenario, find_scenario

SCENARIO = find_scenario("hybrid-goback")


def finite(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False).map(lambda x: x + 0.0)


ROLLING = [
    name for name in robot_names() if all(leg.foot == "steerable" for leg in find_robot(name).leg_list)
]
"""Robots that get anywhere without steps."""


@st.composite
def scenarios(draw: st.DrawFn) -> dict[str, Any]:
    """Data of a valid scenario, keys left out at random."""
    horizon = draw(finite(4.0, 20.0))
    pause = draw(finite(0.0, 0.4))
    gait = draw(
        st.one_of(
            st.just("drive"),
            st.just({"kind": "crawl", "steps": 2, "pause_start": pause, "order": ["FL", "HR"]}),
            st.just({"kind": "schedule", "FL": [[0.5, 1.5]], "HR": [[1.6, 2.6], [3.0, 4.0]]}),
        )
    )
    optional = {
        "description": st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"])),
        "start": st.fixed_dictionaries({"x": finite(-0.3, 0.3), "heading_deg": st.just({"FL": 20.0})}),
        "interval": finite(0.05, 0.2),
        "profile": st.sampled_from(["paper", "executable"]),
        "ground": st.fixed_dictionaries({"height": finite(-2, 2), "friction": finite(0.1, 1.0)}),
        "weights": st.dictionaries(st.sampled_from(["acc", "tilt", "lift"]), st.none() | finite(0, 1e6)),
        "bounds": st.fixed_dictionaries({"box": st.none() | st.tuples(*[finite(1e-3, 1)] * 3).map(list)}),
    }
    chosen = draw(st.fixed_dictionaries({}, optional=optional))
    robot = draw(st.sampled_from(ROLLING))
    goal = {"x": draw(finite(-0.1, 0.3)), "yaw_deg": draw(finite(-400, 400))}
    return {"robot": robot, "goal": goal, "horizon": horizon, "gait": gait} | chosen


@given(scenarios())
@settings(deadline=None)
def test_yaml_keeps_every_scenario(data: dict[str, Any]) -> None:
    scenario = Scenario.from_dict(data)
    assert Scenario.from_dict(scenario.to_dict()) == scenario
    assert Scenario.from_dict(parse_yaml(scenario.to_yaml(), "text")) == scenario
    resolved = scenario.resolved()
    assert Scenario.from_dict(parse_yaml(resolved.to_yaml(), "text")) == resolved
    assert resolved.resolved() == resolved
    complete = scenario.self_contained()
    assert Scenario.from_dict(parse_yaml(complete.to_yaml(), "text")) == complete
    assert complete.body == scenario.body


TEXT = st.one_of(
    st.text("ab: #-'\"1e,"),
    st.text(st.characters(codec="utf-8")),
    st.sampled_from(["true", "~", "1e3", "a: b", "a #b", "2001-01-01"]),
)


@given(st.recursive(st.booleans() | st.integers() | st.floats(allow_nan=False) | TEXT, st.lists))
def test_dumped_values_read_back(value: Any) -> None:
    assert parse_yaml(dump_yaml({"key": value}), "text") == {"key": value}


def keys(model: type[BaseModel], prefix: str = "") -> list[str]:
    """Dotted names of all keys of the scenario, for tests that shall reach each of them."""
    found = []
    for name, field in model.model_fields.items():
        found.append(prefix + name)
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            found += keys(field.annotation, f"{prefix}{name}.")
    return found


KEYS = [
    *keys(Scenario),
    "gait.kind",
    "gait.steps",
    "gait.order",
    "goal.then.0.at",
    "robot.mass",
    "robot.legs.FL.foot",
]
JUNK = st.one_of(
    st.text(max_size=20),
    st.text("[]{}:,&*!#|>-?%@`'\"~0123456789.eE+_ \n", max_size=20),
    st.floats().map(str),
    st.integers(-(10**400), 10**400).map(lambda n: f"{n:x}"),
    st.sampled_from(
        ["2001-99-99", "&a [*a]", "{1: 2}", "{[1]: 2}", "!!python/object:os.system x", "[" * 2000]
    ),
    st.sampled_from(
        ["1e308", "-1e308", "1e-308", "1e999", "0b2", "0o9", "=", "<<: 3", ".inf", "~", "crawl", "drive"]
    ),
)


@given(key=st.sampled_from(KEYS) | st.text(".0aδ²", max_size=6), junk=JUNK)
@settings(deadline=None, max_examples=400)
def test_junk_in_a_setting_is_an_input_error_or_fine(key: str, junk: str) -> None:
    with contextlib.suppress(InputError):
        name, value = parse_setting(f"{key}={junk}")
        SCENARIO.with_values({name: value})


@given(st.text(max_size=40) | st.binary(max_size=40).map(repr))
def test_junk_as_a_file_is_a_file_error_or_fine(text: str) -> None:
    with contextlib.suppress(FileError):
        assert isinstance(parse_yaml(text, "text"), dict)


@pytest.mark.parametrize(
    "key", [k for k in KEYS if k.startswith(("start.x", "goal.x", "horizon", "interval", "ground.height"))]
)
@pytest.mark.parametrize("value", ["1.5", True, None, math.nan, math.inf, [1.0], {"x": 1.0}])
def test_what_is_no_number_is_refused_where_one_is_needed(key: str, value: Any) -> None:
    with pytest.raises(InputError) as caught:
        SCENARIO.with_values({key: value})
    if key == "horizon" and isinstance(value, dict):  # it may be one, with other keys
        assert "max, price" in str(caught.value)
        return
    assert "number" in str(caught.value)
    assert caught.value.field == key


@pytest.mark.parametrize("group", ["weights", "bounds"])
def test_every_weight_and_bound_refuses_text(group: str) -> None:
    for name in type(getattr(SCENARIO, group)).model_fields:
        with pytest.raises(InputError) as caught:
            SCENARIO.with_values({f"{group}.{name}": "1"})
        assert caught.value.field == f"{group}.{name}"


def test_data_built_in_python_breaks_rules_with_the_same_errors() -> None:
    with pytest.raises(InputError) as caught:
        Goal(x=math.nan)
    assert caught.value.field == "x"
    with pytest.raises(InputError) as caught:
        Scenario(robot="centauro", goal={"x": 1.0, "then": [{"at": 1.0, "x": "far"}]})  # type: ignore[arg-type]
    assert (caught.value.field, caught.value.value) == ("goal.then.0.x", "far")


def test_settings_are_read_as_yaml() -> None:
    assert parse_setting("goal.x=1e-3") == ("goal.x", 1e-3)
    assert parse_setting("a.b=[1, x, true]") == ("a.b", [1, "x", True])
    assert parse_value("a: b: c") == "a: b: c"


def test_a_list_has_places() -> None:
    data = {"goal": {"then": [{"x": 1.0}]}}
    set_key(data, "goal.then.0.x", 2.0)
    assert data == {"goal": {"then": [{"x": 2.0}]}}
    with pytest.raises(InputError, match="valid: 0"):
        set_key(data, "goal.then.1.x", 2.0)


def test_a_gait_is_chosen_by_its_name_or_its_kind() -> None:
    crawl = SCENARIO.with_values({"gait.clearance": 0.1})
    assert crawl.with_values({"gait": "drive"}).gait.clearance is None
    assert crawl.with_values({"gait.kind": "drive"}).gait.clearance == 0.1


def test_another_kind_of_gait_keeps_what_was_asked_and_no_default_of_the_old_one() -> None:
    crawl = Scenario.from_dict({"robot": "centauro", "goal": {"x": 0.3}, "gait": "crawl"})
    walk = crawl.with_values({"gait.kind": "walk"})
    assert (crawl.gait.wheels, walk.gait.wheels) == ("rolling", "locked")
    assert walk.with_values({"gait.kind": "trot"}).gait.wheels == "rolling"
    assert walk.with_values({"gait.wheels": "rolling"}).gait.wheels == "rolling"
    assert crawl.with_values({"gait.wheels": "locked", "gait.kind": "trot"}).gait.wheels == "locked"


def test_a_single_figure_of_the_robot_can_be_set() -> None:
    heavy = SCENARIO.with_values({"robot.mass": 200.0})
    assert heavy.body.mass == 200.0
    assert [leg.stance for leg in heavy.body.leg_list] == [leg.stance for leg in SCENARIO.body.leg_list]
    assert tuple(type(heavy.body.legs).model_fields) == LEG_NAMES
