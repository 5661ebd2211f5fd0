"""The product in front of BLASFEO: used where it is right, whoever else is loaded, and only there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rollgait as rg
from rollgait.plan.plan import Plan
from rollgait.solvers import linear_algebra
from rollgait.solvers.linear_algebra import BLASFEO, BLASFEO_WITH_PRODUCT, SWITCH
from rollgait.solvers.product_code import FUNCTION, SOURCE
from rollgait.solvers.two_stages import error_of_two_stages

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux") or shutil.which("cc") is None, reason="needs Linux and a compiler"
)

PLANNING = """
import logging, sys
logging.basicConfig(format="log: %(message)s", level=logging.INFO, stream=sys.stdout)
{before}
import rollgait as rg
scenario = rg.find_scenario("wheeled").with_values({{"horizon": 2.0, "goal": {{"x": 0.1}}}})
statistics = rg.plan(scenario, kernels={kernels}).statistics
print("used:", statistics.linear_algebra)
print("cost:", round(statistics.cost, 6))
{after}
"""
QP = """
{load}
import numpy as np, scipy.sparse as sp
random = np.random.default_rng(0)
root = random.normal(size=(20, 20))
P, c = root @ root.T + np.eye(20), random.normal(size=20)
A, b = random.normal(size=(5, 20)), random.normal(size=5)
qp = piqp.SparseSolver()
qp.settings.kkt_solver = piqp.KKTSolver.sparse_multistage
qp.setup(sp.csc_matrix(P), c, sp.csc_matrix(A), b)
qp.solve()
kkt = np.block([[P, A.T], [A, np.zeros((5, 5))]])
assert np.abs(qp.result.x - np.linalg.solve(kkt, np.concatenate([-c, b]))[:20]).max() < 1e-6
"""
"""Piqp has a BLASFEO of its own, by default the one that this processor likes best."""
FOR_ANY_PROCESSOR = """
import importlib.util
from pathlib import Path
folder = Path(importlib.util.find_spec("piqp").origin).parent
(file,) = folder.glob("piqp_python.*")
spec = importlib.util.spec_from_file_location("piqp_python", file)
piqp = importlib.util.module_from_spec(spec)
spec.loader.exec_module(piqp)
"""


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Kernels are compiled once for all tests here."""
    return tmp_path_factory.mktemp("cache")


def planned(
    cache: Path, before: str = "", after: str = "", kernels: bool = True, **environment: str
) -> dict[str, str]:
    """What a process prints that plans, by the first word of the line."""
    done = subprocess.run(
        [sys.executable, "-c", PLANNING.format(before=before, after=after, kernels=kernels)],
        env=os.environ | {"ROLLGAIT_CACHE": str(cache)} | environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return dict(line.split(": ", 1) for line in done.stdout.splitlines())


@pytest.fixture(scope="module")
def cost(cache: Path) -> float:
    """What the plan costs without the product."""
    lines = planned(cache, **{SWITCH: "off"})
    assert lines["used"] == BLASFEO
    return float(lines["cost"])


def test_statistics_name_it_and_files_keep_it(tmp_path: Path) -> None:
    scenario = rg.find_scenario("wheeled").with_values({"horizon": 2.0, "goal": {"x": 0.1}})
    plan = rg.plan(scenario, solver="ipopt", kernels=False)
    assert plan.statistics.linear_algebra == "MUMPS"
    assert Plan.load(plan.save(tmp_path / "plan.npz")).statistics.linear_algebra == "MUMPS"


def test_it_is_used_where_there_is_a_compiler(cache: Path, cost: float) -> None:
    lines = planned(cache)
    assert lines["used"] == BLASFEO_WITH_PRODUCT
    assert float(lines["cost"]) == pytest.approx(cost, rel=1e-4)


def test_without_kernels_it_is_not_used(cache: Path) -> None:
    assert planned(cache, kernels=False)["used"] == BLASFEO


@pytest.mark.parametrize(
    ("package", "use"),
    [
        ("mujoco", "import mujoco; mujoco.MjModel.from_xml_string('<mujoco/>')"),
        ("pinocchio", "import pinocchio as pin; pin.crba(*(lambda m: (m, m.createData(), pin.neutral(m)))"
         "(pin.buildSampleModelManipulator()))"),
        ("piqp", QP.format(load="import piqp")),
        # those that other processors get: these have the product by the same name
        ("piqp", QP.format(load=FOR_ANY_PROCESSOR)),
    ],
    ids=["mujoco", "pinocchio", "piqp", "piqp for any processor"],
)  # fmt: skip
@pytest.mark.parametrize("order", ["before", "after"])
def test_others_and_it_leave_each_other_alone(
    package: str, use: str, order: str, cache: Path, cost: float
) -> None:
    pytest.importorskip(package)
    lines = planned(cache, **{order: use})
    assert lines["used"] == BLASFEO_WITH_PRODUCT
    assert float(lines["cost"]) == pytest.approx(cost, rel=1e-4)


LOADED_BEFORE = "from rollgait.solvers.fatrop_library import library; library()"
OTHER_PANEL = "from rollgait.solvers import fatrop_library as c; c.PANEL = 8"
OTHER_VERSION = """
from rollgait.solvers import fatrop_library as c
def other(): raise c.InterfaceError("blasfeo 0.1.4 is not in CasADi's wheel")
c.library_files = other
"""
WRONG = """
from rollgait.solvers import linear_algebra as l
{check}
l.SOURCE = l.SOURCE.replace("*alpha * (even[j] + odd[j])", "*alpha * even[j]")
"""
"""A compiler that makes the product wrong, found by what `check` leaves to find it."""
TRUSTING = "l._multiplies = lambda function: True"


@pytest.mark.parametrize(
    ("before", "said"),
    [
        (LOADED_BEFORE, "no product of our own in BLASFEO: it was loaded before"),
        (OTHER_VERSION, "blasfeo 0.1.4 is not in CasADi's wheel: planning without a product of our own"),
        (WRONG.format(check=""), "a compiled kernel cannot be loaded (the compiled matrix product is wrong"),
        (WRONG.format(check=TRUSTING), "BLASFEO: a problem of two stages is not solved with it"),
    ],
    ids=["loaded before", "another version", "wrong, seen at once", "wrong, seen by fatrop"],
)
def test_where_it_cannot_be_trusted_nothing_changes(
    before: str, said: str, cost: float, tmp_path: Path
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PLANNING.format(before=before, after="", kernels=True)],
        env=os.environ | {"ROLLGAIT_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert f"used: {BLASFEO}\n" in done.stdout
    assert f"cost: {cost}\n" in done.stdout


def test_another_panel_size_is_seen(cache: Path) -> None:
    script = f"""
import logging, sys
logging.basicConfig(format="%(message)s", level=logging.INFO, stream=sys.stdout)
{OTHER_PANEL}
from rollgait.solvers.linear_algebra import use_fast_products
print(use_fast_products())
"""
    environment = os.environ | {"ROLLGAIT_CACHE": str(cache)}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True)
    lines = done.stdout.splitlines()
    assert lines[-2:] == ["no product of our own in BLASFEO: its panels have 4 rows, not 8", "False"], (
        done.stderr
    )


def test_a_problem_of_two_stages_is_solved_in_this_process() -> None:
    assert error_of_two_stages() < linear_algebra.TOLERANCE


def test_the_product_has_the_name_that_blasfeo_calls() -> None:
    assert f"void {FUNCTION}(" in SOURCE
