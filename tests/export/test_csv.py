"""The columns of the CSV file are a contract: names, order, meaning, every digit."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from rollgait.errors import FileError, InputError, UnknownNameError
from rollgait.export import FORMATS, write
from rollgait.export.csv import columns
from rollgait.plan.plan import Plan
from rollgait.scenario import find_scenario
from tests.view.builders import motion_plan

RATE = 30.0
HEAD = ["time", "com_x", "com_y", "com_z", "yaw", "pitch", "roll"]
HEAD += ["com_vx", "com_vy", "com_vz", "yaw_rate", "pitch_rate", "roll_rate"]
LEG = ["x", "y", "z", "heading", "fx", "fy", "fz", "speed", "heading_rate", "height_rate", "contact"]
LEGS = ("FL", "FR", "HL", "HR")
COLUMNS = HEAD + [f"{leg}_{name}" for leg in LEGS for name in LEG]
ACROSS = [f"{leg}_{name}" for leg in LEGS for name in ("vx", "vy")]
TOUCH = [f"{leg}_{name}" for leg in LEGS for name in ("cx", "cy", "cz", "nx", "ny", "nz")]
RATES = ["com_ax", "com_ay", "com_az", "yaw_acceleration", "pitch_acceleration", "roll_acceleration"]


def plan_with(feet: str) -> Plan:
    scenario = find_scenario("hybrid-goback")
    return motion_plan(scenario, scenario.body.with_feet(feet))  # type: ignore[arg-type]


def read(path: Path) -> tuple[list[str], list[list[str]]]:
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    return header, rows


@pytest.mark.parametrize(
    ("feet", "names"),
    [
        ("steerable", COLUMNS + TOUCH + RATES),
        ("fixed", COLUMNS + ACROSS + TOUCH + RATES),
        ("point", COLUMNS + ACROSS + TOUCH + RATES),
    ],
)
def test_columns_and_rows(feet: str, names: list[str], tmp_path: Path) -> None:
    plan = plan_with(feet)
    path = write(plan, tmp_path / "plan.csv", "csv", RATE)
    header, rows = read(path)
    assert header == names
    assert len(rows) == len(plan.sample_every(RATE).time)
    assert {len(row) for row in rows} == {len(names)}


@pytest.mark.parametrize("feet", ["steerable", "fixed", "point"])
def test_every_number_comes_back_to_the_last_digit(feet: str, tmp_path: Path) -> None:
    plan = plan_with(feet)
    header, rows = read(write(plan, tmp_path / "plan.csv", "csv", RATE))
    data = np.array(rows, dtype=float)
    table = {name: data[:, header.index(name)] for name in header}
    s = plan.sample_every(RATE)
    expected = {"time": s.time}
    for axis, letter in enumerate("xyz"):
        expected[f"com_{letter}"] = s.com_position[:, axis]
        expected[f"com_v{letter}"] = s.com_velocity[:, axis]
    for axis, angle in enumerate(("yaw", "pitch", "roll")):
        expected[angle] = s.euler[:, axis]
        expected[f"{angle}_rate"] = s.euler_rate[:, axis]
    for i, leg in enumerate(LEGS):
        for axis, letter in enumerate("xyz"):
            expected[f"{leg}_{letter}"] = s.foot_position[:, i, axis]
            expected[f"{leg}_f{letter}"] = s.force[:, i, axis]
            expected[f"{leg}_c{letter}"] = s.contact_position[:, i, axis]
            expected[f"{leg}_n{letter}"] = s.contact_normal[:, i, axis]
        expected[f"{leg}_heading"] = s.heading[:, i]
        expected[f"{leg}_speed"] = s.speed[:, i]
        expected[f"{leg}_heading_rate"] = s.heading_rate[:, i]
        expected[f"{leg}_height_rate"] = s.foot_velocity[:, i, 2]
        expected[f"{leg}_contact"] = s.contact[:, i].astype(float)
        if feet != "steerable":
            expected[f"{leg}_vx"], expected[f"{leg}_vy"] = s.foot_velocity[:, i, :2].T
    assert set(table) - set(expected) == set(RATES)
    for name, values in expected.items():
        np.testing.assert_array_equal(table[name], values, name)


def test_contact_is_0_or_1(tmp_path: Path) -> None:
    header, rows = read(write(plan_with("steerable"), tmp_path / "plan.csv", rate=RATE))
    for leg in LEGS:
        assert {row[header.index(f"{leg}_contact")] for row in rows} == {"0", "1"}


def test_point_feet_leave_heading_and_speed_at_0(tmp_path: Path) -> None:
    header, rows = read(write(plan_with("point"), tmp_path / "plan.csv", rate=RATE))
    for name in [f"{leg}_{what}" for leg in LEGS for what in ("heading", "speed", "heading_rate")]:
        assert {float(row[header.index(name)]) for row in rows} == {0.0}


def test_wrong_input(tmp_path: Path) -> None:
    plan = plan_with("steerable")
    with pytest.raises(UnknownNameError) as caught:
        write(plan, tmp_path / "plan.cvs", "cvs")
    assert caught.value.choices[0] == "csv"
    assert set(caught.value.choices) == set(FORMATS)
    with pytest.raises(InputError, match="rate"):
        write(plan, tmp_path / "plan.csv", "csv", 0.0)
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        write(plan, tmp_path / "file" / "plan.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("of", ["com", "turn"])
def test_accelerations_are_those_of_the_places(of: str) -> None:
    """By second differences of places and angles, which the columns are not made of."""
    rate = 200.0
    plan = motion_plan(find_scenario("wheeled"))
    table = columns(plan.sample_every(rate), plan.robot)
    angles = ("yaw", "pitch", "roll")
    places = [f"com_{axis}" for axis in "xyz"] if of == "com" else list(angles)
    found = [f"com_a{axis}" for axis in "xyz"] if of == "com" else [f"{a}_acceleration" for a in angles]
    for place, name in zip(places, found, strict=True):
        second = np.diff(table[place], 2) * rate**2
        np.testing.assert_allclose(table[name][1:-1], second, atol=2e-3)
    assert max(np.abs(table[name]).max() for name in found) > 0.02
