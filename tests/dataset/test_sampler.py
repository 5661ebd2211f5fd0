"""Rows are drawn from seed and number alone, as the distributions say."""

from __future__ import annotations

import pickle
from collections import Counter
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.config import dump_yaml
from rollgait.dataset import Distribution, Sampler, Spec
from rollgait.dataset.sampler import share_of
from tests.dataset.builders import BASE, spec

ROWS = range(30)
SHARES = (0.7778083790056476, 0.5587506430690521)
"""Of seed 7, rows 0 and 123456."""
OF_BELL = 2.52962487
"""Where the first of them lies in the bell of mean 1 and deviation 2."""


def sampler(**changes: Any) -> Sampler:
    return Sampler.of(Spec.from_dict(spec(**{"count": len(ROWS)} | changes)))


def test_a_row_needs_no_other_and_no_state() -> None:
    one, other = sampler(), pickle.loads(pickle.dumps(sampler()))
    forwards = [one.asked(row) for row in ROWS]
    assert forwards == [other.asked(row) for row in reversed(ROWS)][::-1]
    assert forwards == [sampler(count=1000).asked(row) for row in ROWS]
    assert forwards != [sampler(seed=6).asked(row) for row in ROWS]


def test_random_numbers_are_the_same_everywhere() -> None:
    """By what the hash is, not by what this machine makes of it."""
    assert share_of(7, 0, "goal.x") == SHARES[0]
    assert share_of(7, 123456, "goal.yaw_deg") == SHARES[1]
    assert Distribution(normal=(1.0, 2.0)).at(SHARES[0], 0) == OF_BELL


def test_a_further_key_leaves_the_others_as_they_are() -> None:
    vary = spec()["vary"]
    more = sampler(vary={**vary, "ground.friction": {"choice": [0.5, 0.8]}})
    for row in ROWS:
        values = dict(more.asked(row).values)
        assert values.pop("ground.friction") in (0.5, 0.8)
        assert values == sampler().asked(row).values


@given(st.integers(0, 2**62), st.integers(0, 10**7), st.floats(-1e3, 1e3), st.floats(0.0, 1e3))
def test_numbers_stay_in_their_range(seed: int, row: int, low: float, width: float) -> None:
    share = share_of(seed, row, "x")
    assert 0.0 <= share < 1.0
    high = low + width
    assert low - 1e-9 <= Distribution(uniform=(low, high)).at(share, 0) <= high + 1e-9
    bell = Distribution(normal=(low + 0.5 * width, 1.0 + width), within=(low, high + 1e-3))
    assert low - 1e-9 <= bell.at(share, 0) <= high + 1e-3 + 1e-9


def test_draws_are_distributed_as_said() -> None:
    """Within five standard errors, for a fixed seed."""
    shares = [share_of(1, row, "x") for row in range(4000)]
    uniform = [Distribution(uniform=(2.0, 4.0)).at(share, 0) for share in shares]
    assert np.mean(uniform) == pytest.approx(3.0, abs=5 * 2 / np.sqrt(12 * 4000))
    normal = [Distribution(normal=(1.0, 0.5)).at(share, 0) for share in shares]
    assert np.mean(normal) == pytest.approx(1.0, abs=5 * 0.5 / np.sqrt(4000))
    assert np.std(normal) == pytest.approx(0.5, abs=5 * 0.5 / np.sqrt(2 * 4000))
    chosen = Counter(Distribution(choice=("a", "b"), weights=(3.0, 1.0)).at(share, 0) for share in shares)
    assert chosen["a"] / 4000 == pytest.approx(0.75, abs=5 * np.sqrt(0.75 * 0.25 / 4000))


def test_grids_are_crossed_lists_go_in_step_and_shares_are_exact() -> None:
    vary = {
        "goal.x": {"grid": [0.1, 0.2, 0.3]},
        "goal.y": {"grid": [0.0, 0.01]},
        "goal.yaw_deg": {"list": [1, 2, 3, 4]},
    }
    families = {"crossed": {"base": BASE, "share": 2, "vary": vary}, "other": {"base": BASE}}
    drawn = [sampler(families=families, vary={}).asked(row) for row in ROWS]
    assert Counter(asked.family for asked in drawn) == {"crossed": 20, "other": 10}
    crossed = [asked.values for asked in drawn if asked.family == "crossed"]
    first = [(values["goal.x"], values["goal.y"]) for values in crossed[:6]]
    assert sorted(first) == sorted(product((0.1, 0.2, 0.3), (0.0, 0.01)))
    assert [values["goal.yaw_deg"] for values in crossed[:6]] == [1, 2, 3, 4, 1, 2]


def test_robots_gaits_grounds_loads_and_weights_vary(tmp_path: Path) -> None:
    robot = rg.find_robot("rover")
    (tmp_path / "mine.yaml").write_text(
        dump_yaml(robot.model_dump(mode="json", exclude_none=True)), encoding="utf-8"
    )
    np.save(tmp_path / "bumps.npy", np.zeros((60, 40)))
    height_map = {"map": {"file": "bumps.npy", "resolution": 0.1, "origin": [-2.0, -2.0]}}
    vary = {
        "robot": {"list": ["centauro", "mine.yaml"]},
        "robot.mass": {"uniform": [95.0, 100.0]},
        "gait": {"choice": ["crawl", {"kind": "walk"}, "drive"]},
        "ground": {"list": [{"friction": 0.7}, {"friction": 0.7}, height_map]},
        "ground.height": {"choice": [0.0]},
        "loads.payload": {"choice": [[{"mass": 2.0, "at": [0.0, 0.0, 0.2]}]]},
        "weights.effort": {"uniform": [0.5, 2.0]},
    }
    base = {"robot": "centauro", "goal": {"x": 0.2}, "horizon": 12.0}
    data = {"count": 6, "families": {"all": {"base": base, "vary": vary}}}
    file = tmp_path / "spec.yaml"
    file.write_text(dump_yaml(data), encoding="utf-8")
    drawn = pickle.loads(pickle.dumps(Sampler.of(Spec.from_yaml(file), tmp_path)))
    scenarios = [drawn.scenario(drawn.asked(row)) for row in range(6)]
    assert [s.body.name for s in scenarios] == ["centauro", robot.name] * 3
    assert [s.ground.kind for s in scenarios] == ["flat", "flat", "map"] * 2
    assert all(97.0 <= s.body.mass <= 102.0 for s in scenarios)
    again = Sampler.from_dict(drawn.to_dict(), drawn.maps)
    assert [again.scenario(again.asked(row)).to_dict() for row in range(6)] == [
        s.to_dict() for s in scenarios
    ]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"count": 0}, "count: 0 must be at least 1"),
        ({"families": {}}, "families"),
        ({"vary": {"goal.y": {"unifrom": [0, 1]}}}, "vary.goal.y.unifrom"),
        ({"vary": {"goal.y": {"choice": []}}}, "choice: [] must have at least 1 value"),
        ({"vary": {"goal.y": {}}}, "exactly one of uniform, normal, choice, list, grid, not none"),
        ({"vary": {"goal.y": {"uniform": [1, 0]}}}, "in this order"),
        ({"vary": {"goal.y": {"choice": [1], "grid": [2]}}}, "not choice and grid"),
        ({"vary": {"goal.y": {"choice": [1, 2], "weights": [1]}}}, "2 weights"),
        ({"vary": {"goal.y": {"uniform": [0, 1], "weights": [1]}}}, "belongs to 'choice'"),
        ({"vary": {"goal.y": {"normal": [0, 1], "within": [50, 60]}}}, "reaches into"),
        ({"families": {"a": {"base": "wheelde"}}}, "families.a.base.scenario: 'wheelde'"),
    ],
)
def test_a_wrong_spec_is_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(rg.InputError) as caught:
        Sampler.of(Spec.from_dict(spec(**changes)))
    assert message in str(caught.value)
