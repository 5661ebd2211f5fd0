"""The short texts for disturbances: what is written is read back, all else is refused by one sentence."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.plant.disturbances import DIRECTIONS, PUSH_DURATION, parse_quantity
from rollgait.simulation import Disturbances, Payload, Push

positive = st.floats(1e-3, 1e6)
moments = st.floats(0.0, 1e3)
angles = st.floats(-360.0, 360.0)
places = st.tuples(*[st.floats(-2.0, 2.0)] * 3)


@given(positive, angles, moments, positive)
def test_a_push_reads_back(force: float, angle: float, start: float, duration: float) -> None:
    push = Push(force=force, direction_deg=angle, start=start, duration=duration)
    assert Push.parse(str(push)) == push


@given(positive, st.sampled_from(sorted(DIRECTIONS)), moments)
def test_named_directions(force: float, name: str, start: float) -> None:
    push = Push.parse(f"{force!r}N:{name}@{start!r}s")
    assert (push.direction_deg, push.duration) == (DIRECTIONS[name], PUSH_DURATION)
    assert math.hypot(*push.vector) == pytest.approx(force)
    sign = -1.0 if "-" in name else 1.0
    assert push.vector["xy".index(name[-1])] == pytest.approx(sign * force)


def test_the_short_form() -> None:
    assert Push.parse("50N@3s") == Push.parse(" 50N@3 ") == Push(force=50.0, start=3.0)


@given(positive, places)
def test_a_payload_reads_back(mass: float, place: tuple[float, float, float]) -> None:
    payload = Payload(mass=mass, place=place)
    assert Payload.parse(str(payload)) == payload


@given(st.text(alphabet=st.characters(exclude_characters="0123456789")))
def test_any_other_text_is_refused_in_one_sentence(text: str) -> None:
    for parse in (Push.parse, Payload.parse, lambda t: parse_quantity("latency", t)):
        with pytest.raises(InputError) as refused:
            parse(text)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "text", ["50", "50N", "@3s", "50@3s", "-5N@3s", "0N@3s", "5N@-1s", "5N:up@3s", "5N@3s:0s", "nanN@3s"]
)
def test_pushes_that_are_none(text: str) -> None:
    with pytest.raises(InputError):
        Push.parse(text)


@pytest.mark.parametrize("text", ["5", "kg", "-5kg", "5kg@1,2", "5kg@a,b,c", "5kg@1,2,3,4"])
def test_payloads_that_are_none(text: str) -> None:
    with pytest.raises(InputError):
        Payload.parse(text)


@given(st.floats(-1e3, 1e3))
def test_units_scale(value: float) -> None:
    assert parse_quantity("latency", f"{value!r}ms") == pytest.approx(1e-3 * value)
    assert parse_quantity("radius-error", f"{value!r}%") == pytest.approx(1e-2 * value)
    assert parse_quantity("slope", f"{value!r}deg") == parse_quantity("slope", repr(value)) == value


@pytest.mark.parametrize(
    ("field", "value"),
    [("friction", 0.0), ("latency", -1e-3), ("latency", 1.0), ("radius_error", 0.9), ("slope_deg", 80.0)],
)
def test_impossible_disturbances(field: str, value: float) -> None:
    with pytest.raises(InputError) as refused:
        Disturbances(**{field: value})
    assert str(refused.value).startswith(f"{field}: {value} must ")
