"""Wrong values of the keys for wheels that skid, for rough ground, and of the options of `search` and
`execute`: one sentence with field, value, rule and valid choices."""

import pytest

from rollgait.cli.app import run

ROVER = ("plan", "rover-crawl", "--set")
SLIP = "robot.legs.FL.slip_max"
KERB = ("plan", "kerb", "--set")
CLEARANCE = "bounds.body_clearance"
FOUND = ("plan", "kerb-discover", "--set")

CASES = {
    # arguments: the whole sentence begins so
    (*ROVER, f"{SLIP}=-1"): f"{SLIP}: -1 must be greater than 0",
    (*ROVER, f"{SLIP}=0"): f"{SLIP}: 0 must be greater than 0",
    (*ROVER, f"{SLIP}=fast"): f"{SLIP}: 'fast' must be a number",
    (*ROVER, f"{SLIP}=.nan"): f"{SLIP}: nan must be a finite number",
    (*ROVER, f"{SLIP}=[0.1, 0.2]"): f"{SLIP}: [0.1, 0.2] must be a number",
    (*ROVER, "robot.legs.FL.slip=0.1"): "robot.legs.FL.slip: 'slip' is not a known key; valid: slip_max",
    (
        "plan",
        "strider-crawl",
        "--set",
        f"{SLIP}=0.1",
    ): f"{SLIP}: 0.1 must not be given, as the foot is point; valid for: fixed",
    (*KERB, f"{CLEARANCE}=-1"): f"{CLEARANCE}: -1 must not be negative",
    (*KERB, f"{CLEARANCE}=high"): f"{CLEARANCE}: 'high' must be a number",
    (*KERB, f"{CLEARANCE}=.inf"): f"{CLEARANCE}: inf must be a finite number",
    (*KERB, f"{CLEARANCE}=5"): f"{CLEARANCE}: 5.0 must be less than ",
    (*KERB, "bounds.body_clearence=0.1"): "bounds.body_clearence: 'body_clearence' is not a known key; "
    "valid: body_clearance",
    (*KERB, "bounds.without=[body]"): "bounds.without: 'body' is no term of this problem; valid: ",
    (*FOUND, "gait.search.candidates=0"): "gait.search.candidates: 0 must be greater than or equal to 1",
    (*FOUND, "gait.search.candidates=1.5"): "gait.search.candidates: 1.5 must be a whole number",
    (*FOUND, "gait.search.seconds=soon"): "gait.search.seconds: 'soon' must be a number",
    (*FOUND, "gait.search.second=3"): "gait.search.second: 'second' is not a known key; valid: seconds",
    (*FOUND, "gait.search=7"): "gait.search: 7 must be a mapping of keys to values",
    ("search", "rover-craw"): "scenario: 'rover-craw' is neither a scenario of the library nor a .yaml file; "
    "valid: rover-crawl",
    (
        "search",
        "rover-crawl",
        "--change",
        "fewr",
    ): "changes: 'fewr' must be one of fewer, more, pairs, orders",
    ("search", "rover-crawl", "--candidates", "0"): "--candidates: '0' must be greater than or equal to 1",
    ("search", "rover-crawl", "--candidates", "few"): "--candidates: 'few' must be a whole number",
    ("search", "rover-crawl", "--candidates", "2.5"): "--candidates: '2.5' must be a whole number",
    ("execute",): "PLAN...: must be given",
    ("execute", "no-such.npz"): "plan: 'no-such.npz' cannot be read",
    ("execute", "no-such.npz", "--plnt", "rigid"): "--plnt: is not an option of 'rollgait execute'; "
    "valid: --plant",
    ("execute", "no-such.npz", "--seed", "x"): "--seed: 'x' must be a whole number",
}


@pytest.mark.parametrize("arguments", CASES, ids=" ".join)
def test_one_sentence_names_field_value_rule_and_choices(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"error: {CASES[arguments]}")
    assert err.count("\n") == 1
