"""One small data set for all tests that only read."""

from __future__ import annotations

from pathlib import Path

import pytest

import rollgait as rg
from rollgait.dataset import Spec
from tests.dataset.builders import spec

pytest.importorskip("pyarrow")


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> rg.Dataset:
    """Six rows, the last of which is refused."""
    folder: Path = tmp_path_factory.mktemp("data") / "library"
    return rg.plan_dataset(Spec.from_dict(spec()), folder, workers=1, quiet=True)
