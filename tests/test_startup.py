"""What is loaded when: importing rollgait, asking for help and planning load what they need, and no more."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import rollgait as rg

HEAVY = {
    *("casadi", "joblib", "matplotlib", "mujoco", "numpy", "pinocchio", "pydantic", "rich", "ruamel"),
    *("scipy", "viser"),
}
"""Packages that take more than a few milliseconds to import."""


OF_EXTRAS = (
    *("viser", "trimesh", "websockets", "pinocchio", "mujoco", "daqp", "piqp", "imageio", "mcap", "rosbags"),
    *("pandas", "xarray", "rasterio", "dask", "pyarrow", "foxglove", "cyclonedds"),
)
"""Packages that a plain installation has not."""


def loaded_by(code: str, folder: Path | None = None) -> set[str]:
    """The modules that a new process has after `code`."""
    tail = "; import sys; print('\\n' + ' '.join(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", code + tail], cwd=folder, check=True, capture_output=True, text=True
    )
    return set(done.stdout.splitlines()[-1].split())


def shell(*arguments: str) -> str:
    return f"from rollgait.cli.app import run; assert run({list(arguments)!r}) == 0"


def homes_in_source() -> dict[str, str]:
    """Module of each name, by the imports that a type checker reads."""
    tree = ast.parse(Path(rg.__file__).read_text(encoding="utf-8"))
    imports = (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom))
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def test_importing_rollgait_loads_nothing_heavy() -> None:
    loaded = loaded_by("import rollgait")
    assert not loaded & HEAVY
    assert {name for name in loaded if name.startswith("rollgait")} <= {
        "rollgait",
        "rollgait.lazy",
        "rollgait.plan",
        "rollgait.view",
    }


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_loads_nothing_heavy(option: str) -> None:
    assert not loaded_by(shell(option)) & HEAVY


@pytest.mark.parametrize("arguments", [("plan",), ("mpc",), ("simulate",), ("robot", "import")])
def test_help_of_a_command_loads_what_typer_needs(arguments: tuple[str, ...]) -> None:
    assert loaded_by(shell(*arguments, "--help")) & HEAVY <= {"pydantic"}  # by which typer reads options


def test_a_plan_loads_nothing_for_other_work(tmp_path: Path) -> None:
    loaded = loaded_by(shell("plan", "hybrid-forward", "--out", "plan.npz"), tmp_path)
    assert loaded & HEAVY == {"casadi", "numpy", "pydantic", "rich", "ruamel"}
    other = ("rollgait.mpc", "rollgait.simulation", "rollgait.tracking", "rollgait.view.", "rollgait.many")
    endings = {"rollgait.view.recordings"}  # of files that may be written, and no more
    assert not {name for name in loaded if name.startswith(other)} - endings
    assert not loaded & {"rollgait.diagnosis.elastic", "rollgait.solvers.ipopt"}  # only where it fails


def test_the_certificate_needs_no_solver(tmp_path: Path) -> None:
    planned = "import rollgait as rg; rg.plan('hybrid-forward').save('plan.npz')"
    loaded_by(planned, tmp_path)
    loaded = loaded_by(shell("check", "plan.npz"), tmp_path)
    assert not loaded & {"casadi", "scipy"}


def test_a_plain_installation_plans_draws_and_exports(tmp_path: Path) -> None:
    steps = [
        f"import sys; sys.modules.update(dict.fromkeys({OF_EXTRAS!r}))",
        shell("plan", "hybrid-forward", "--out", "plan.npz"),
        shell("check", "plan.npz"),
        shell("plot", "plan.npz"),
        shell("export", "plan.npz", "--format", "json", "--out", "plan.json"),
        shell("ground", "show", "kerb", "--out", "kerb.png"),
        "import rollgait as rg; plan = rg.Plan.load('plan.npz')",
        "assert all('<img' in x._repr_html_() for x in (plan, plan.scenario, plan.robot))",
        "assert plan.certificate()._repr_html_()",
    ]
    loaded_by("; ".join(steps), tmp_path)
    assert len(list((tmp_path / "plan-figures").iterdir())) > 1


def test_each_name_is_the_one_that_type_checkers_see() -> None:
    homes = homes_in_source()
    for name in rg.__all__:
        assert getattr(rg, name) is getattr(importlib.import_module(homes[name]), name), name
    assert set(rg.__all__) <= set(dir(rg))


def test_all_names_come_with_a_star() -> None:
    names: dict[str, object] = {}
    exec("from rollgait import *", names)
    assert {name: names[name] for name in rg.__all__} == {name: getattr(rg, name) for name in rg.__all__}


def test_a_misspelt_name_is_none() -> None:
    with pytest.raises(AttributeError, match="module 'rollgait' has no attribute 'plam'"):
        rg.plam  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.parametrize(
    "first",
    [
        "import rollgait",
        "import rollgait.plan",
        "import rollgait.plan.plan",
        "import rollgait.plan.certificate.judge",
        "import rollgait.planner",
        "import rollgait.cli.plan",
        "from rollgait.plan import Plan",
        "from rollgait.plan.plan import Plan",
        "from rollgait import plan; import rollgait.plan.plan",
        "import rollgait; rollgait.plan; import rollgait.plan.samples",
        "import rollgait; rollgait.Planner; import rollgait.plan.plan",
    ],
)
def test_plan_is_the_function_whatever_was_imported_before(first: str) -> None:
    """`rollgait.plan` is a package as well, and importing that sets an attribute of the same name."""
    check = "import rollgait as rg; from rollgait import plan; import rollgait.planner as p"
    loaded_by(f"{first}; {check}; assert rg.plan is plan is p.plan and rg.Planner is p.Planner")
