"""Laws of the mesh, and of a contact schedule on a mesh of unequal intervals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.scenario import ContactSchedule, Mesh
from rollgait.scenario.mesh import MAX_INTERVALS

Array = NDArray[np.float64]

lengths = st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=60)
seeds = st.integers(0, 2**32 - 1)


def cut(mesh: Mesh, seed: int) -> tuple[Array, Array]:
    """Some of its intervals, and into how many parts each is to be cut."""
    random = np.random.default_rng(seed)
    which = np.flatnonzero(random.random(mesh.intervals) < 0.5)
    return which, random.integers(1, 6, which.size)


@given(horizon=st.floats(0.1, 100.0), count=st.integers(1, 500))
def test_equal_intervals_have_their_nodes_at_multiples_of_one_length(horizon: float, count: int) -> None:
    mesh = Mesh.equal(horizon, count)
    h = horizon / count
    assert (mesh.is_equal, mesh.intervals) == (True, count)
    np.testing.assert_array_equal(mesh.times, np.arange(count + 1) * h)
    np.testing.assert_array_equal(mesh.between_middles, h)
    assert mesh.horizon == count * h


@given(lengths=lengths)
def test_the_nodes_are_apart_by_the_lengths(lengths: list[float]) -> None:
    mesh = Mesh(np.array(lengths))
    assert mesh.times[0] == 0.0
    np.testing.assert_allclose(np.diff(mesh.times), lengths, rtol=1e-9)
    np.testing.assert_allclose(np.diff(mesh.middles), mesh.between_middles[1:], rtol=1e-9)
    assert mesh.horizon == pytest.approx(sum(lengths))


@given(lengths=lengths, part=st.floats(1e-6, 1.0 - 1e-6))
def test_a_time_lies_in_the_interval_around_it_and_a_node_in_the_later_one(
    lengths: list[float], part: float
) -> None:
    mesh = Mesh(np.array(lengths))
    every = np.arange(mesh.intervals)
    k, passed = mesh.place_of(mesh.times[:-1] + part * mesh.lengths)
    np.testing.assert_array_equal(k, every)
    np.testing.assert_allclose(passed, part, atol=1e-9)
    np.testing.assert_array_equal(mesh.interval_at(mesh.times), [*every, mesh.intervals - 1])
    # a node that another order of summing would give
    np.testing.assert_array_equal(mesh.interval_at(mesh.times[:-1] * (1.0 - 1e-15)), every)
    assert mesh.interval_at(-1.0) == 0
    assert mesh.interval_at(mesh.horizon + 1.0) == mesh.intervals - 1
    assert mesh.interval_at(np.zeros((2, 3))).shape == (2, 3)


@given(lengths=lengths, seed=seeds)
def test_a_refined_mesh_keeps_the_horizon_and_all_nodes(lengths: list[float], seed: int) -> None:
    mesh = Mesh(np.array(lengths))
    which, parts = cut(mesh, seed)
    finer = mesh.refined(which, parts)
    assert finer.intervals == mesh.intervals + (parts - 1).sum()
    assert finer.horizon == pytest.approx(mesh.horizon, rel=1e-12)
    distance = np.abs(finer.times[:, None] - mesh.times).min(axis=0)
    assert distance.max() <= 1e-12 * mesh.horizon
    into = np.ones(mesh.intervals)
    into[which] = parts
    parent = mesh.interval_at(finer.middles)
    np.testing.assert_array_equal(np.bincount(parent), into)
    np.testing.assert_array_equal(finer.lengths, (mesh.lengths / into)[parent])


@given(horizon=st.floats(1.0, 20.0), count=st.integers(1, 100), parts=st.integers(1, 5))
def test_cutting_all_equal_intervals_alike_keeps_them_equal(horizon: float, count: int, parts: int) -> None:
    finer = Mesh.equal(horizon, count).refined(np.ones(count, dtype=bool), parts)
    assert finer.is_equal
    np.testing.assert_allclose(finer.lengths, horizon / count / parts)


def test_a_mask_names_the_intervals_as_their_numbers_do() -> None:
    mesh = Mesh(np.array([0.1, 0.2, 0.3]))
    finer = mesh.refined(np.array([True, False, True]), 2)
    assert finer == mesh.refined([0, 2]) == Mesh(np.array([0.05, 0.05, 0.2, 0.15, 0.15]))
    assert mesh.refined([]) == mesh


def test_meshes_are_data() -> None:
    """Equal by their lengths, usable as keys, and nobody's array can change them."""
    own = np.array([0.1, 0.2])
    mesh = Mesh(own)
    own[0] = 5.0
    np.testing.assert_array_equal(mesh.lengths, [0.1, 0.2])
    assert mesh == Mesh(np.array([0.1, 0.2]))
    assert len({mesh, Mesh(np.array([0.1, 0.2])), Mesh(np.array([0.2, 0.1]))}) == 2
    assert mesh != [0.1, 0.2]
    with pytest.raises(ValueError, match="read-only"):
        mesh.lengths[0] = 1.0


@pytest.mark.parametrize(
    ("lengths", "rule"),
    [
        (np.zeros((2, 2)), r"must be an array of shape \(N,\)"),
        (np.array(0.1), r"must be an array of shape \(N,\)"),
        (np.zeros(0), "N from 1 to 10000"),
        (np.ones(MAX_INTERVALS + 1), "N from 1 to 10000"),
        (np.array([0.1, 0.0]), "0.0 must be a positive number of seconds"),
        (np.array([0.1, -0.2]), "-0.2 must be a positive number of seconds"),
        (np.array([np.nan]), "nan must be a positive number of seconds"),
        (np.array([np.inf]), "inf must be a positive number of seconds"),
    ],
)
def test_what_is_no_mesh(lengths: Array, rule: str) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        Mesh(lengths)
    assert caught.value.field == "mesh.lengths"


@pytest.mark.parametrize(
    ("which", "parts", "field", "rule"),
    [
        ([3], 2, "which", "3 must be the number of an interval, 0 to 2"),
        ([-1], 2, "which", "-1 must be the number of an interval"),
        ([0], 0, "parts", "0 must be at least 1"),
        ([0, 1], [2, -1], "parts", "must be at least 1"),
        ([0], MAX_INTERVALS, "parts", "make at most 10000 intervals"),
    ],
)
def test_how_a_mesh_cannot_be_cut(which: list[int], parts: int | list[int], field: str, rule: str) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        Mesh.equal(0.3, 3).refined(which, parts)
    assert caught.value.field == field


# -- schedules -----------------------------------------------------------------------------------------------


def random_schedule(lengths: list[float], seed: int) -> ContactSchedule:
    contact = np.random.default_rng(seed).random((4, len(lengths))) < 0.6
    return ContactSchedule(contact, Mesh(np.array(lengths)))


@given(lengths=lengths, seed=seeds)
def test_a_refined_schedule_has_the_same_contacts_at_every_time(lengths: list[float], seed: int) -> None:
    schedule = random_schedule(lengths, seed)
    finer = schedule.refined(*cut(schedule.mesh, seed))
    at = schedule.mesh.interval_at(finer.mesh.middles)
    np.testing.assert_array_equal(finer.contact, schedule.contact[:, at])
    for coarse, fine in zip(schedule.swings(), finer.swings(), strict=True):
        assert coarse.leg == fine.leg
        for node in ("lift_off", "touch_down"):
            times = [s.node_times[getattr(p, node)] for s, p in ((schedule, coarse), (finer, fine))]
            assert times[0] == pytest.approx(times[1], abs=1e-9)


@given(lengths=lengths, seed=seeds)
def test_the_middle_node_is_the_nearest_in_time(lengths: list[float], seed: int) -> None:
    schedule = random_schedule(lengths, seed)
    for swing in schedule.swings():
        nodes = schedule.node_times[swing.lift_off : swing.touch_down + 1]
        distance = np.abs(nodes - 0.5 * (nodes[0] + nodes[-1]))
        assert distance[swing.middle - swing.lift_off] == pytest.approx(distance.min(), abs=1e-7)
        if nodes.size > 2:
            assert swing.lift_off < swing.middle < swing.touch_down


@given(lift_off=st.integers(0, 50), length=st.integers(1, 30), horizon=st.floats(1.0, 30.0))
def test_of_two_middle_nodes_it_is_the_earlier(lift_off: int, length: int, horizon: float) -> None:
    contact = np.ones((4, 90), dtype=bool)
    contact[1, lift_off : lift_off + length] = False
    (swing,) = ContactSchedule(contact, Mesh.equal(horizon, 90)).swings()
    assert swing.middle == (2 * lift_off + length) // 2


def test_schedules_are_equal_by_contacts_and_mesh() -> None:
    contact = np.ones((4, 2), dtype=bool)
    schedule = ContactSchedule(contact, Mesh(np.array([0.1, 0.2])))
    assert schedule == ContactSchedule(contact.copy(), Mesh(np.array([0.1, 0.2])))
    assert schedule != ContactSchedule(contact, Mesh(np.array([0.2, 0.1])))
    assert len({schedule, ContactSchedule(contact.copy(), schedule.mesh)}) == 1


@pytest.mark.parametrize("shape", [(4, 3), (5, 2), (4,)])
def test_contacts_must_fit_the_mesh(shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match=r"contact: .* must have the shape \(4, 2\)"):
        ContactSchedule(np.ones(shape, dtype=bool), Mesh.equal(1.0, 2))


@given(lengths=lengths, shares=st.lists(st.floats(0.01, 0.99), max_size=5))
def test_a_mesh_cut_at_times_has_them_and_all_its_nodes(lengths: list[float], shares: list[float]) -> None:
    mesh = Mesh(np.array(lengths))
    cut = mesh.cut_at(mesh.horizon * np.array(shares))
    assert cut.horizon == pytest.approx(mesh.horizon)
    for time in (*mesh.times, *(mesh.horizon * share for share in shares)):
        assert np.abs(cut.times - time).min() < 1e-9 * mesh.horizon
    assert cut.intervals <= mesh.intervals + len(set(shares))


@pytest.mark.parametrize("time", [0.0, -0.1, 1.0, 2.0, np.nan])
def test_a_mesh_is_cut_within_its_horizon_alone(time: float) -> None:
    with pytest.raises(InputError, match="between"):
        Mesh.equal(1.0, 10).cut_at([time])
