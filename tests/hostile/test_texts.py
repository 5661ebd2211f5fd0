"""Hostile texts: YAML that grows when it is read, numbers without end, and what messages show of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.config import TEXT_MAX, parse_setting, parse_yaml
from rollgait.errors import MESSAGE_LENGTH, FileError, InputError, RollgaitError
from rollgait.scenario import Scenario, find_scenario
from tests.hostile.conftest import Run


def nested(depth: int, width: int, form: str) -> str:
    """Anchors of which each holds several of the one before, in this form: width ** depth values."""
    lines = ["a0: &a0 {x: 1}"]
    for level in range(1, depth + 1):
        inside = ", ".join([f"*a{level - 1}"] * width)
        lines.append(f"a{level}: &a{level} {form.replace('…', inside)}")
    return "\n".join(lines)


LONG_NUMBER = "0x" + 5000 * "f"
TEXTS = {
    "nested anchors": (nested(9, 9, "[…]"), "its aliases make it too large"),
    "nested merge keys": (nested(9, 9, "{<<: […]}"), "its aliases make it too large"),
    "one long text, often": (
        f"a: &a {'x' * 100_000}\nb: [{', '.join(['*a'] * 1000)}]",
        "its aliases make it too large",
    ),
    "many keys": ("\n".join(f"k{n}: 1" for n in range(200_000)), "is too large: 2.09 MB"),
    "fewer keys": ("\n".join(f"k{n}: 1" for n in range(45_000)), "it holds more than 30000 keys and values"),
    "a long text": ("description: " + 100_000_000 * "x", "is too large: 100 MB; at most 0.5 MB are read"),
    "deep lists": (200_000 * "[", "it is nested more than 50 deep"),
    "deep mappings": (100_000 * "{a: ", "it is nested more than 50 deep"),
    "deep by indentation": ("\n".join(" " * n + "a:" for n in range(900)), "it is nested more than 50 deep"),
    "zeros": (100_000 * "\0", "is not valid YAML"),
    "a long number": ("goal: {x: " + LONG_NUMBER + "}", "goal.x: 0xfffff"),
    "a long decimal": ("goal: {x: " + 5000 * "9" + "}", "is not valid YAML"),
    "a long key": ("? " + "k" * 300_000 + "\n: 1", "kkk…kkk"),
    "a key that steers the terminal": ('"\\e[2J\\u202e\\r": 1', r"\x1b[2J\u202e\r: '\x1b[2J\u202e\r' is not"),
    "a list that holds itself": ("goal: &a [*a]", "goal: "),
    "a mapping that holds itself": ("goal: &a {x: *a}", "goal"),
    "an object": ("!!python/object/apply:os.mkdir [made]", "is not valid YAML"),
}


@pytest.mark.parametrize(("text", "says"), TEXTS.values(), ids=list(TEXTS))
def test_a_scenario_that_is_too_much_is_refused(text: str, says: str, tmp_path: Path, rollgait: Run) -> None:
    robot = "" if text.startswith(("[", "{", "!", "\0", " ", "a:\n")) else "\nrobot: centauro"
    (tmp_path / "hostile.yaml").write_text(text + robot)
    rollgait("plan", "hostile.yaml").assert_refused(says)


@pytest.mark.parametrize("command", [["robot", "import"], ["mpc", "--command"]], ids=" ".join)
def test_other_files_have_the_same_limits(command: list[str], tmp_path: Path, rollgait: Run) -> None:
    (tmp_path / "hostile.yaml").write_text(TEXTS["nested anchors"][0])
    rollgait(*command, "hostile.yaml").assert_refused("its aliases make it too large")


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        (f"goal.x={LONG_NUMBER}", "goal.x: 0xfffff"),
        (f"goal.x={5000 * '9'}", "goal.x: '99999"),
        (f"gait={LONG_NUMBER}", "gait: 0xfffff"),
        (f"horizon=-{LONG_NUMBER}", "horizon: -0xfff"),
        (f"goal.x.y={LONG_NUMBER}", "goal.x.y: 0xfffff"),
        (f"goal.then.{5000 * '9'}.x=1", "the list is empty"),
        ("goal.x=" + 50_000 * "[", "must be a number"),
        ("goal.x=" + 50_000 * "x", "must be a number"),
        ("\x1b[31m.x=1", r"\x1b[31m"),
    ],
    ids=lambda text: text[:12],
)
def test_a_hostile_setting_is_refused(setting: str, says: str, rollgait: Run) -> None:
    rollgait("plan", "wheeled", "--set", setting).assert_refused(says)


def test_a_long_number_stays_one_where_another_setting_meets_it(rollgait: Run) -> None:
    rollgait("plan", "wheeled", "--set", f"goal.x={LONG_NUMBER}", "--set", "goal.x.y=1").assert_refused(
        "goal.x.y: 1 cannot be set: goal.x is 0xfffff"
    )


@pytest.mark.parametrize("name", ["iterations", "period"])
def test_settings_of_the_controller_have_numbers_of_a_size(name: str, rollgait: Run) -> None:
    rollgait("mpc", "--set", f"{name}={LONG_NUMBER}").assert_refused(f"{name}: 0xfffff")


# -- messages ------------------------------------------------------------------------------------------------


@given(
    field=st.text() | st.integers(1, 10**6).map(lambda n: "k" * n),
    value=st.text() | st.integers() | st.just(10**100_000) | st.lists(st.text(), max_size=30),
    choices=st.lists(st.text(), max_size=100),
)
def test_a_message_is_bounded_and_printable(field: str, value: Any, choices: list[str]) -> None:
    error = InputError(field, value, "must be something else", choices)
    assert len(str(error)) < 10 * MESSAGE_LENGTH  # an escape takes up to ten characters
    assert str(error).replace("\n", "").isprintable()
    assert (error.field, error.value) == (field, value)


def test_the_message_of_any_error_is_bounded() -> None:
    assert len(str(RollgaitError(1_000_000 * "x"))) == MESSAGE_LENGTH
    many = InputError("name", "x", "is not known", [f"choice-{n}" for n in range(1000)])
    assert str(many).endswith("choice-49, and 950 more")


# -- anything ------------------------------------------------------------------------------------------------

PIECES = [
    *"\n\t:-?,[]{}&*!|>'\"%@`#~ a1.",
    *("\n  ", ": ", "- ", "? ", "<<: ", "*a", "&a ", "---\n", "...\n", "%YAML 1.1\n", "\\x", "\x1b"),
    *("!!int ", "!!binary ", "!!set ", "!!timestamp ", "0x", "0o7", "1e400", ".nan", ".inf", "1_0", "\ufeff"),
    *("2001-99-99", "2001-01-01"),
    *("goal", "robot", "centauro", "x", "then", "gait", "horizon", "null", "true", "interval", "at"),
]


@settings(max_examples=1000)
@given(st.lists(st.sampled_from(PIECES), max_size=40).map("".join) | st.text(max_size=60))
def test_any_text_is_a_mapping_or_refused(text: str) -> None:
    try:
        data = parse_yaml(text, "text.yaml")
        assert isinstance(data, dict)
        Scenario.from_dict(data)
    except InputError as error:
        assert str(error).isprintable()  # noqa: PT017 (either way is right)


@given(
    st.sampled_from(["goal.x", "goal", "gait", "gait.kind", "robot", "horizon", "goal.then", "x"]),
    st.lists(st.sampled_from(PIECES), max_size=12).map("".join),
)
def test_any_setting_is_taken_or_refused(key: str, text: str) -> None:
    wheeled = find_scenario("wheeled")
    try:
        wheeled.with_values(dict([parse_setting(f"{key}={text}")]))
    except InputError as error:
        assert str(error).isprintable()  # noqa: PT017 (either way is right)


def test_a_text_of_the_largest_size_is_read() -> None:
    assert parse_yaml(f"a: {'x' * (TEXT_MAX - 3)}", "long.yaml")["a"][-1] == "x"
    with pytest.raises(FileError, match="longer than"):
        parse_yaml(f"a: {'x' * TEXT_MAX}", "long.yaml")
